"""Pix2Pix: depth from a picture by a conditional adversarial network (needs PyTorch)."""
