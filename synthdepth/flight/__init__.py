"""Clearance queries and random drone flights."""
