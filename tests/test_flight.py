import dataclasses

import numpy as np
import pytest

from synthdepth.errors import FlightError, RecipeError
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import FlightLimits, body_from_cam, draw_flight
from synthdepth.flight.primitives import evaluate, minimum_jerk
from synthdepth.maps.geometry import box, copies, geometry, join, quads, tube
from synthdepth.maps.world import Light, World
from synthdepth.seeding import lane

LIGHT = Light(
    condition="clear",
    sun_azimuth_deg=0,
    sun_elevation_deg=45,
    turbidity=3,
    visibility_m=1e4,
)


def level(points):
    return np.zeros(len(points))


def world(surfaces, half=60.0, ground_m=level):
    return World(
        map="test",
        scene_seed=0,
        surfaces=surfaces,
        materials={},
        light=LIGHT,
        flight_bounds=np.array([[-half, -half], [half, half]]),
        ground_m=ground_m,
    )


def plate(half, ground_m=level, cells=16):
    g = np.linspace(-half, half, cells + 1)
    x, y = np.meshgrid(g, g, indexing="ij")
    corners = np.stack([x, y, ground_m(np.stack([x, y], -1).reshape(-1, 2)).reshape(x.shape)], -1)
    c = corners
    return quads(np.stack([c[:-1, :-1], c[1:, :-1], c[1:, 1:], c[:-1, 1:]], 2).reshape(-1, 4, 3))


def exact_distance(points, triangles):
    """Distance (n,) of points (n, 3) to the nearest of triangles (m, 3, 3), brute force, float64:
    the plane where the foot lies inside, else the nearest edge."""
    tri = triangles.astype(np.float64)
    edges = np.roll(tri, -1, axis=1) - tri
    normal = np.cross(edges[:, 0], edges[:, 1])
    area = np.linalg.norm(normal, axis=1)
    unit = normal / np.maximum(area, 1e-30)[:, None]
    best = np.full(len(points), np.inf)
    for i in range(0, len(tri), 4096):
        t, e, u = tri[i : i + 4096], edges[i : i + 4096], unit[i : i + 4096]
        solid = area[i : i + 4096] > 1e-12
        for j in range(0, len(points), 256):
            q = points[j : j + 256, None, None] - t  # (n, m, 3 corners, 3)
            length = np.maximum((e * e).sum(-1), 1e-30)
            s = np.clip((q * e).sum(-1) / length, 0, 1)
            distance = np.linalg.norm(q - s[..., None] * e, axis=-1).min(-1)
            inside = ((np.cross(e, q) * u[:, None]).sum(-1) >= 0).all(-1) & solid
            height = np.abs((q[:, :, 0] * u).sum(-1))
            distance = np.where(inside, height, distance).min(axis=1)
            best[j : j + 256] = np.minimum(best[j : j + 256], distance)
    return best


def street(half=150.0):
    """Houses along streets, a wall of flats, posts, trees of loose leaves, wires."""
    rng = lane(3, "street")
    x = np.arange(-half - 20, half + 21, 22.0)
    y = np.arange(-half + 10, half, 40.0)
    at = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2) + rng.uniform(-2, 2, (len(x) * len(y), 2))
    height = rng.choice([6.0, 8.0, 25.0], len(at), p=[0.5, 0.4, 0.1])
    size = np.column_stack([rng.uniform(9, 14, (len(at), 2)), height])
    ground = np.zeros((len(at), 1))
    posts = np.stack(np.meshgrid(np.arange(-half, half, 30.0), y + 14), -1).reshape(-1, 2)
    posts = np.column_stack([posts, np.full(len(posts), -0.1)])
    s = np.linspace(0, 30, 9)
    span = tube(np.stack([s, 0 * s, 8.6 + 0.8 * (s / 15 - 1) ** 2], 1), 0.01, 3, capped=False)
    trees = np.column_stack([rng.uniform(-half, half, (60, 2)), np.zeros(60)])
    trees[:, 1] = np.round(trees[:, 1] / 40) * 40 + 25
    centre = rng.normal(size=(60, 3)) * 1.2 + [0, 0, 5.5]
    leaf = rng.normal(size=(2, 60, 3)) * 0.15
    crown = quads(
        np.stack([centre - leaf[0], centre - leaf[1], centre + leaf[0], centre + leaf[1]], 1)
    )
    surfaces = {
        ("grass", "ground"): plate(half + 60),
        ("siding", "building"): copies(box((1, 1, 1)), np.hstack([at, ground - 0.05]), scale=size),
        ("wood", "pole"): copies(tube([[0, 0, 0], [0, 0, 9.6]], 0.14), posts),
        ("metal", "wire"): copies(span, posts),
        ("bark", "tree_trunk"): copies(tube([[0, 0, -0.1], [0, 0, 5]], 0.15), trees),
        ("leaf", "vegetation"): copies(crown, trees),
    }
    return world(surfaces, half)


@pytest.fixture(scope="module")
def streets():
    w = street()
    return w, Clearance(w)


LIMITS = FlightLimits(duration_s=(5.0, 12.0))


@pytest.fixture(scope="module")
def flights(streets):
    return [draw_flight(lane(1, "flight", i), streets[1], LIMITS) for i in range(30)]


def test_exact_distance_of_known_points():
    tri = np.array([[[0, 0, 0], [4, 0, 0], [0, 3, 0]]], np.float32)
    points = np.array([[1, 1, 5], [-3, 0, 4], [2, -2, 0], [4, 3, 0], [1, 1, 0.0]])
    np.testing.assert_allclose(exact_distance(points, tri), [5, 5, 2, 2.4, 0], atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_bound_never_exceeds_the_exact_distance(seed):
    """Slivers, leaves, walls, wires and slopes, many times the same distances by brute force."""
    rng = lane(seed, "mesh")
    size = np.exp(rng.uniform(np.log(0.01), np.log(30), 250))[:, None, None]
    stretch = np.exp(rng.uniform(-5, 0, (250, 1, 3)))
    loose = rng.uniform(-20, 20, (250, 1, 3)) + rng.normal(size=(250, 3, 3)) * size * stretch
    loose[..., 2] += 22
    s = np.linspace(-30, 30, 9)
    wire = tube(np.stack([s, 0.3 * s, 9 + (s / 30) ** 2], 1), 0.01, 3)
    walls = copies(box((12, 0.2, 30)), rng.uniform(-20, 20, (4, 3)) * [1, 1, 0])

    def hills(p):
        return 1.5 * np.sin(p[:, 0] / 14) + 0.01 * p[:, 1]

    surfaces = {
        ("paint", "obstacle"): geometry(loose, np.arange(750).reshape(-1, 3)),
        ("metal", "wire"): wire,
        ("plaster", "building"): walls,
        ("grass", "ground"): plate(90, hills, 40),
    }
    w = world(surfaces, 25, hills)
    clearance = Clearance(w)
    triangles = np.concatenate([g.triangles for g in surfaces.values()])
    near = triangles[rng.integers(0, len(triangles), 200)].mean(axis=1)
    near = near + rng.normal(size=(200, 3)) * 0.8
    points = np.concatenate([rng.uniform([-25, -25, -2], [25, 25, 40], (250, 3)), near])
    points = points[(np.abs(points[:, :2]) < 25).all(axis=1) & (points[:, 2] < 40)]
    exact, bound = exact_distance(points, triangles), clearance(points)
    assert (bound <= exact + 1e-6).all()
    # Below the ground everything is solid; beyond 4 m the coarse tree answers.
    above = points[:, 2] > hills(points[:, :2])
    close = above & (exact < 4)
    assert close.sum() > 100
    assert (exact - bound)[close].max() <= 0.5
    assert (np.minimum(exact, 30) - bound)[above].max() <= 2.0


def test_bound_sees_a_wire_and_a_tower_beyond_the_ceiling():
    tower = box((30, 30, 300))
    w = world(
        {("metal", "wire"): tube([[-50, 9, 7], [50, 9, 7]], 0.01, 3), ("glass", "building"): tower}
    )
    clearance = Clearance(w)
    x = np.linspace(-40, 40, 400)
    along = clearance(np.stack([x, 0 * x + 40, 0 * x + 7], 1))
    wire = clearance(np.stack([x, 0 * x + 12, 0 * x + 7], 1)[np.abs(x) > 20])
    assert (along <= 25).all()
    assert (wire <= 3).all()
    assert wire.min() > 2.4
    inside = np.array([[0, 0, 20.0], [20, 0, 20]])
    assert clearance.covered(inside).tolist() == [True, False]


def test_bound_of_an_empty_world_is_its_reach():
    clearance = Clearance(world({}, 30))
    np.testing.assert_array_equal(
        clearance(np.array([[0, 0, 3.0], [40, 0, 3], [99, 0, 3]])), [30, 19.99, 0]
    )


def test_primitive_reaches_its_terminal_velocity_with_least_jerk():
    rng = lane(0, "primitive")
    p, v, a = rng.normal(size=(3, 3)) * [[9], [9], [3]]
    end, T = rng.normal(size=(5, 3)) * 8, rng.uniform(1, 3, 5)
    c = minimum_jerk(p, v, a, end, T)
    zero = np.zeros((5, 1))
    for order, value in enumerate((p, v, a)):
        np.testing.assert_allclose(evaluate(c, zero, order)[:, 0], np.tile(value, (5, 1)))
    np.testing.assert_allclose(evaluate(c, T[:, None], 1)[:, 0], end, atol=1e-9)
    np.testing.assert_allclose(evaluate(c, T[:, None], 2)[:, 0], 0, atol=1e-9)
    # A free terminal position costs no jerk: it is zero there (the transversality condition on
    # position makes alpha 0, so jerk is linear). Any admissible change of the motion adds jerk.
    t = np.linspace(0, 1, 2001)
    bump = (T[:, None] * t) ** 3 * (T[:, None] * (1 - t)) ** 3  # position, velocity, acc. stay
    third = np.gradient(np.gradient(np.gradient(bump, axis=1), axis=1), axis=1)
    j = evaluate(c, T[:, None] * t, 3)[..., 0]
    assert (np.abs((j * third).sum(axis=1)) < 1e-2 * np.abs(j * third).sum(axis=1)).all()


def test_flights_keep_the_limits_between_frames(flights):
    for flight in flights:
        t = np.arange(0, flight.time_s[-1], 0.005)
        p = flight.state_at(t).position_m
        v, a, j = (np.diff(p, n, axis=0) / 0.005**n for n in (1, 2, 3))
        assert np.linalg.norm(v, axis=1).max() <= LIMITS.max_speed_mps + 1e-6
        assert np.linalg.norm(a, axis=1).max() <= LIMITS.max_acceleration_mps2 + 1e-4
        assert np.linalg.norm(j, axis=1).max() <= LIMITS.max_jerk_mps3 + 1e-2
        yaw = flight.attitude.yaw_rad(t)
        rate, acceleration = (np.degrees(np.diff(yaw, n)) / 0.005**n for n in (1, 2))
        assert np.abs(rate).max() <= LIMITS.max_yaw_rate_dps + 1e-6
        assert np.abs(acceleration).max() <= LIMITS.max_yaw_acceleration_dps2 + 1e-3
        assert flight.altitude_m.min() >= LIMITS.altitude_m[0]
        assert flight.altitude_m.max() <= LIMITS.altitude_m[1]
        assert LIMITS.duration_s[0] - 0.1 <= flight.time_s[-1] <= LIMITS.duration_s[1]
        np.testing.assert_array_equal(flight.time_s, np.arange(len(flight.time_s)) * 0.1)


def test_flights_touch_nothing(streets, flights):
    w, clearance = streets
    triangles = np.concatenate([g.triangles for g in w.surfaces.values()])
    centre, reach = triangles.mean(axis=1), np.linalg.norm(np.ptp(triangles, axis=1), axis=1)
    for flight in flights[:12]:
        p = flight.state_at(np.arange(0, flight.time_s[-1], 0.02)).position_m
        low, high = p.min(axis=0) - 3, p.max(axis=0) + 3
        around = ((centre + reach[:, None] > low) & (centre - reach[:, None] < high)).all(axis=1)
        bound = clearance(p)
        tight = p[bound < 3]
        if len(tight):
            exact = exact_distance(tight, triangles[around])
            assert exact.min() >= LIMITS.drone_radius_m + LIMITS.margin_m
            assert (bound[bound < 3] <= exact + 1e-6).all()
        at = flight.state.position_m
        assert (flight.clearance_m >= clearance(at)).all()
        exact = exact_distance(at[::20], triangles)
        assert (flight.clearance_m[::20] <= exact).all()
        assert (np.minimum(exact, 30) - flight.clearance_m[::20]).max() <= 0.5
        assert not clearance.covered(flight.state.position_m[:1]).any()


def test_attitude_is_a_drones(flights):
    for flight in flights:
        t = np.arange(0, flight.time_s[-1], 0.02)
        state = flight.state_at(t)
        R = state.world_from_body
        np.testing.assert_allclose(
            R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (len(t), 1, 1)), atol=1e-12
        )
        tilt = np.degrees(np.arccos(R[:, 2, 2]))
        assert tilt.max() <= LIMITS.max_tilt_deg
        # Thrust is what acceleration, weight and drag ask for, but for the airframe's inertia.
        force = state.acceleration_mps2 + 0.15 * state.velocity_mps + [0, 0, 9.81]
        force /= np.linalg.norm(force, axis=1, keepdims=True)
        assert np.degrees(np.arccos(np.clip((force * R[:, :, 2]).sum(1), -1, 1))).max() < 8
        step = np.einsum("nji,njk->nik", R[:-1], R[1:])
        turned = np.degrees(np.arccos(np.clip((np.trace(step, axis1=1, axis2=2) - 1) / 2, -1, 1)))
        assert turned.max() / 0.02 < 250


def test_camera_axes(flights):
    off = []
    for flight in flights:
        pose = flight.state.world_from_cam
        R = pose[:, :3, :3]
        np.testing.assert_allclose(np.linalg.det(R), 1)
        np.testing.assert_allclose(
            R.transpose(0, 2, 1) @ R, np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-12
        )
        np.testing.assert_array_equal(pose[:, :3, 3], flight.state.position_m)
        assert (R[:, 2, 1] < -0.4).all()  # down is down
        v = flight.state.velocity_mps
        fast = np.hypot(v[:, 0], v[:, 1]) > 1
        course, view = np.arctan2(v[:, 1], v[:, 0]), np.arctan2(R[:, 1, 2], R[:, 0, 2])
        off.append(np.abs((view - course + np.pi) % (2 * np.pi) - np.pi)[fast])
    off = np.degrees(np.concatenate(off))
    assert np.median(off) < 20
    assert np.percentile(off, 99) < 60


def test_camera_mount_looks_down_for_negative_pitch():
    R = body_from_cam(-30.0)
    np.testing.assert_allclose(R[:, 0], [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(R[:, 2], [np.cos(np.pi / 6), 0, -0.5], atol=1e-12)
    np.testing.assert_allclose(R[:, 1], [-0.5, 0, -np.cos(np.pi / 6)], atol=1e-12)


def test_flights_are_varied_and_purposeful(flights):
    nearest = np.array([f.clearance_m.min() for f in flights])
    assert (nearest < 3).sum() >= 6
    assert (nearest > 15).sum() >= 2
    straight, gained = [], []
    for f in flights:
        p = f.state.position_m
        way = np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
        straight.append(np.linalg.norm(p[-1] - p[0]) / way)
        gained.append(
            np.linalg.norm(f.mission.goal_m - p[0]) - np.linalg.norm(f.mission.goal_m - p[-1])
        )
    assert np.median(straight) > 0.8
    assert min(straight) < 0.95
    assert (np.array(gained) > 0).mean() > 0.9


def test_same_lane_same_flight(streets, flights):
    again = draw_flight(lane(1, "flight", 4), streets[1], LIMITS)
    assert again.state.world_from_cam.tobytes() == flights[4].state.world_from_cam.tobytes()
    assert again.clearance_m.tobytes() == flights[4].clearance_m.tobytes()
    assert not np.array_equal(flights[5].mission.start_m, flights[4].mission.start_m)


def test_no_flight_inside_a_hall():
    """A hollow building is roomy inside, but flights stay outdoors."""
    w = world({("plaster", "building"): box((80, 80, 30)), ("grass", "ground"): plate(120)}, 60)
    limits = dataclasses.replace(LIMITS, altitude_m=(2, 25), distance_m=(30, 100))
    clearance = Clearance(w)
    for i in range(4):
        p = draw_flight(lane(2, i), clearance, limits).state.position_m
        assert (np.abs(p[:, :2]).max(axis=1) > 40).all()


def test_fast_flights_do_not_jump_through_thin_walls():
    """Walls of 5 cm, much farther apart than the planner's samples, each with a gate."""
    rng = lane(4, "gates")
    walls = []
    for x in range(-90, 91, 30):
        gate = rng.uniform(-40, 40)
        walls += [box((0.05, 100 + gate - 5, 60), (x, (gate - 5 - 100) / 2, 0))]
        walls += [box((0.05, 100 - gate - 5, 60), (x, (gate + 5 + 100) / 2, 0))]
    w = world({("plaster", "barrier"): join(walls)}, 100)
    limits = dataclasses.replace(LIMITS, speed_mps=(15, 22.2), altitude_m=(4, 30))
    clearance = Clearance(w)
    triangles = join(walls).triangles
    crossed = 0
    for i in range(5):
        flight = draw_flight(lane(6, i), clearance, limits)
        p = flight.state_at(np.arange(0, flight.time_s[-1], 0.01)).position_m
        near = p[clearance(p) < 2]
        if len(near):
            assert exact_distance(near, triangles).min() >= limits.needed_m
        crossed += np.ptp(p[:, 0]) > 31
    assert crossed >= 1


def test_blocked_world_is_an_error():
    at = np.stack(np.meshgrid(np.arange(-22, 23, 1.2), np.arange(-22, 23, 1.2)), -1).reshape(-1, 2)
    posts = copies(tube([[0, 0, 0], [0, 0, 60]], 0.2, 3), np.column_stack([at, 0 * at[:, 0]]))
    w = world({("wood", "pole"): posts}, 20)
    with pytest.raises(FlightError, match=r"in 40 draws \(start blocked: 40\)"):
        draw_flight(lane(0), Clearance(w), LIMITS)


def test_short_world_says_what_is_missing():
    """Walls all round a yard too small for the distance asked for."""
    with pytest.raises(FlightError, match="no free goal: 40"):
        draw_flight(lane(0), Clearance(world({("grass", "ground"): plate(60)}, 15)), LIMITS)


def test_limits_refuse_nonsense():
    with pytest.raises(RecipeError, match="altitude_m"):
        FlightLimits(altitude_m=(40, 2))
    with pytest.raises(RecipeError, match="max_speed_mps"):
        FlightLimits(max_speed_mps=5)
    with pytest.raises(RecipeError, match="frame_interval_s"):
        FlightLimits(frame_interval_s=0)


def test_join_of_nothing_flies_free():
    surfaces = {("paint", "obstacle"): join([])}
    assert Clearance(world(surfaces, 30)).sample_count == 0
