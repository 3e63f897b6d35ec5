"""Closed-loop flights: depth pictures steer a drone through worlds that it can crash into."""
