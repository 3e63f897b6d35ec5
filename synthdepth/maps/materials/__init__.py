"""Textures and materials, baked anew for each scene."""
