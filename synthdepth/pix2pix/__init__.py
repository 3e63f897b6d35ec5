"""Pix2Pix: depth from a picture by a conditional adversarial network (needs PyTorch)."""

import os

# Threads of PyTorch that have nothing to do spin, and take the cores from OpenCV's: flow between
# two pictures then takes twice as long. OpenMP reads this when PyTorch is loaded, which is later.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")
