"""The coast: land, sea, and what stands and floats there."""
