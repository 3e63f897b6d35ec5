"""Cars, vans and buses."""
