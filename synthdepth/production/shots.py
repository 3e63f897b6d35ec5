"""Which frames of which flights become the pairs of a scene."""

import dataclasses

import numpy as np

from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import Flight, draw_flight
from synthdepth.production.recipe import Recipe, SamplingRecipe
from synthdepth.seeding import lane

# How often a pair that fails the gate is drawn again.
REDRAWS = 3


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shot:
    """One pair to render: which frames of which flight.

    Attributes:
        flight_index: within the scene.
        frame_index: frame t within its flight; frame t-1 is the one before.
        prev_number: running number of frame t-1's picture within the scene, its noise seed.
        number: likewise of frame t; the frame t-1 of the next pair of a burst.
    """

    flight_index: int
    frame_index: int
    prev_number: int
    number: int


def burst_starts(rng: np.random.Generator, frames: int, sampling: SamplingRecipe) -> np.ndarray:
    """First frames of a flight's bursts, (bursts,) int64 ascending; bursts never overlap.

    Args:
        rng: the flight's lane.
        frames: number of frames of the flight, at least `sampling.frames_per_flight`.
        sampling: burst length and pairs per flight.
    """
    bursts = sampling.bursts_per_flight
    slack = frames - sampling.frames_per_flight
    gaps = np.sort(rng.integers(0, slack + 1, bursts))
    return gaps + (sampling.burst_pairs + 1) * np.arange(bursts)


def shots_of_flight(
    rng: np.random.Generator, flight_index: int, frames: int, sampling: SamplingRecipe
) -> list[Shot]:
    """The pairs of one flight, in order."""
    length = sampling.burst_pairs + 1
    first = flight_index * sampling.frames_per_flight
    shots = [
        Shot(
            flight_index=flight_index,
            frame_index=int(start) + k,
            prev_number=first + burst * length + k - 1,
            number=first + burst * length + k,
        )
        for burst, start in enumerate(burst_starts(rng, frames, sampling))
        for k in range(1, length)
    ]
    return shots[: sampling.pairs_per_flight]


def draw_flights(
    scene_seed: int, pairs: int, clearance: Clearance, recipe: Recipe
) -> tuple[list[Flight], list[Shot]]:
    """As many of a scene's flights as `pairs` need, and the shots on them, in order.

    Every flight has lanes of its own, so flight 3 is the same whether 4 or 40 are drawn.
    """
    sampling = recipe.sampling
    flights: list[Flight] = []
    shots: list[Shot] = []
    while len(shots) < pairs:
        index = len(flights)
        flight = draw_flight(lane(scene_seed, "flight", index), clearance, recipe.flight)
        flights.append(flight)
        bursts = lane(scene_seed, "bursts", index)
        shots += shots_of_flight(bursts, index, len(flight.time_s), sampling)
    return flights, shots[:pairs]


def spares(scene_seed: int, shot: Shot, frames: int, sampling: SamplingRecipe) -> list[Shot]:
    """What is drawn instead of a shot that fails the gate, in order: other frames of its flight.

    They are the shot's own: no other shot has any of them, whichever fail.

    Args:
        scene_seed: of the scene.
        shot: one of the flight's.
        frames: number of frames of the flight.
        sampling: as the shots were drawn.
    """
    index = shot.flight_index
    planned = shots_of_flight(lane(scene_seed, "bursts", index), index, frames, sampling)
    taken = [one.frame_index for one in planned]
    free = np.setdiff1d(np.arange(1, frames), taken)
    order = lane(scene_seed, "redraw", index).permutation(free)
    mine = order[taken.index(shot.frame_index) :: len(taken)][:REDRAWS]
    return [dataclasses.replace(shot, frame_index=int(frame)) for frame in mine]
