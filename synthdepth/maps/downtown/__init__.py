"""A city's downtown: streets and blocks, their surface, traffic, furnishing, park and sites."""
