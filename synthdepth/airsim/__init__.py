"""Recordings of the simulator AirSim (Colosseum, Cosys-AirSim), read into the contract."""
