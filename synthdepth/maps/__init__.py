"""Procedural worlds: numpy only, no renderer."""
