"""Lots and what people put in their gardens."""
