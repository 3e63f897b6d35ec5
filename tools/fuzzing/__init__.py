"""What `tools/fuzz.py` feeds: malformed files, and the readers that must refuse them."""
