# SPDX-License-Identifier: MIT
"""Priors of the camera's motion: their arguments, a gyroscope's turns, and where they arrive."""

import json
import math
import os
import subprocess

import numpy as np
import pytest

import dynfilter

PLACES = np.float32([[10.5, 20.25], [30, 40], [50, 60]])
SMALL = 1e-6 * np.eye(3)


def turn(vector):
    """The rotation of a rotation vector [rad], by the series of the matrix exponential."""
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return sum(np.linalg.matrix_power(cross, k) / math.factorial(k) for k in range(20))


def covariance(n):
    return np.diag(np.arange(1.0, n + 1)) + 0.25


def test_a_prior_has_what_it_is_given():
    R = turn((0.1, 0.2, 0.3))
    prior = dynfilter.MotionPrior(R, covariance(3))
    np.testing.assert_array_equal(prior.rotation, R)
    np.testing.assert_array_equal(prior.covariance, covariance(3))
    assert prior.translation is None and prior.frame_id == -1
    whole = dynfilter.MotionPrior(R.tolist(), covariance(6), (1, 2, 3), 7)
    np.testing.assert_array_equal(whole.covariance, covariance(6))
    np.testing.assert_array_equal(whole.translation, [1, 2, 3])
    assert whole.frame_id == 7 and whole.rotation.shape == (3, 3)
    for name in ("rotation", "covariance", "translation", "frame_id"):
        with pytest.raises(AttributeError):
            setattr(whole, name, 1)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"rotation": np.eye(4)}, r"rotation: expected numbers of shape \(3, 3\), got an array of shape \(4, 4\)"),
        ({"rotation": None}, r"rotation: expected numbers of shape \(3, 3\), got"),
        ({"rotation": 2 * np.eye(3)}, "rotation: expected a rotation, got another 3x3 matrix"),
        ({"rotation": np.diag([1, 1, -1])}, "rotation: expected a rotation"),
        ({"rotation": np.full((3, 3), np.nan)}, "rotation: expected a rotation"),
        ({"covariance": np.eye(6)}, r"covariance: expected numbers of shape \(3, 3\), got an array of shape \(6, 6\)"),
        ({"translation": (0, 0, 1)}, r"covariance: expected numbers of shape \(6, 6\), got an array of shape \(3, 3\)"),
        ({"covariance": 1e-6}, r"covariance: expected numbers of shape \(3, 3\)"),
        ({"covariance": np.diag([1, 1, 0])}, "covariance: expected finite numbers, those of the diagonal above 0"),
        ({"covariance": np.diag([1, -1, 1])}, "covariance: expected finite numbers"),
        ({"covariance": np.diag([1, np.inf, 1])}, "covariance: expected finite numbers"),
        ({"covariance": np.eye(3) + [[0, np.nan, 0], [0, 0, 0], [0, 0, 0]]}, "covariance: expected finite numbers"),
        ({"covariance": np.diag([0, 1, 1, 1, 1, 1]), "translation": (0, 0, 1)}, "covariance: expected finite numbers"),
        ({"translation": (0, 1), "covariance": np.eye(6)}, r"translation: expected numbers of shape \(3,\)"),
        ({"translation": (0, 1, np.inf), "covariance": np.eye(6)}, "translation: expected finite numbers, got NaN or infinity"),
        ({"frame_id": 0.5}, "frame_id: expected an integer, got a float"),
    ],
)
def test_wrong_priors_are_refused(arguments, message):
    with pytest.raises(ValueError, match="^" + message):
        dynfilter.MotionPrior(**{"rotation": np.eye(3), "covariance": SMALL, **arguments})


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda g: dynfilter.Gyroscope(2 * np.eye(3)), "R_camera_body: expected a rotation"),
        (lambda g: dynfilter.Gyroscope(np.eye(4)), r"R_camera_body: expected numbers of shape \(3, 3\)"),
        (lambda g: dynfilter.Gyroscope(noise_density=0), "noise_density: expected a finite number above 0, got 0.0"),
        (lambda g: dynfilter.Gyroscope(bias_walk=-1), "bias_walk: expected a finite number above 0"),
        (lambda g: dynfilter.Gyroscope(first_bias="small"), "first_bias: expected a number, got a str"),
        (lambda g: dynfilter.Gyroscope(kept_s=0), "kept_s: expected a number above 0, got 0.0"),
        (lambda g: dynfilter.Gyroscope(kept_s=np.nan), "kept_s: expected a number above 0, got nan"),
        (lambda g: g.add("now", (0, 0, 1)), "timestamp: expected a number, got a str"),
        (lambda g: g.add(None, (0, 0, 1)), "timestamp: expected a number, got None"),
        (lambda g: g.add(0.0, (0, 1)), r"omega: expected numbers of shape \(3,\), got an array of shape \(2,\)"),
        (lambda g: g.add([0.0, 0.1], (0, 0, 1)), r"omega: expected numbers of shape \(2, 3\), got an array of shape \(3,\)"),
        (lambda g: g.add(np.zeros((2, 2)), np.zeros((2, 3))), r"timestamp: expected numbers of shape \(n,\)"),
        (lambda g: g.observe(0.0, 0.1, np.eye(4)), r"rotation: expected numbers of shape \(3, 3\)"),
        (lambda g: g.observe(0.0, 0.1, 2 * np.eye(3)), "rotation: expected a rotation"),
    ],
)
def test_wrong_arguments_of_a_gyroscope_are_named(call, message):
    with pytest.raises(ValueError, match="^" + message):
        call(dynfilter.Gyroscope())


RATE = np.array([0.1, -0.2, 0.3])
STAMPS = np.arange(0, 2, 0.005)


def test_a_constant_rate_is_that_turn():
    """The camera turns by the rate times the time, so what it sees turns back."""
    many, one_by_one = dynfilter.Gyroscope(), dynfilter.Gyroscope()
    many.add(STAMPS, np.tile(RATE, (len(STAMPS), 1)))
    for stamp in STAMPS:
        one_by_one.add(stamp, RATE)
    for gyroscope in (many, one_by_one):
        prior = gyroscope.prior(0.5, 1.5)
        np.testing.assert_allclose(prior.rotation, turn(-RATE), atol=1e-9)
        assert prior.translation is None and prior.frame_id == -1
        assert prior.covariance.shape == (3, 3) and (np.linalg.eigvalsh(prior.covariance) > 0).all()
        assert gyroscope.prior(1.5, 2.5) is None and gyroscope.prior(1.0, 1.0) is None
    np.testing.assert_array_equal(many.prior(0.5, 1.5).covariance, one_by_one.prior(0.5, 1.5).covariance)


def test_axes_noise_and_memory():
    R_camera_body = turn((0.3, 1.2, -0.7))
    rates = np.tile(RATE, (len(STAMPS), 1))
    turned, noisy = dynfilter.Gyroscope(R_camera_body), dynfilter.Gyroscope(noise_density=0.1)
    short, usual = dynfilter.Gyroscope(kept_s=0.5), dynfilter.Gyroscope()
    for gyroscope in (turned, noisy, short, usual):
        gyroscope.add(STAMPS, rates)
    np.testing.assert_allclose(turned.prior(0.5, 1.5).rotation, turn(-R_camera_body @ RATE), atol=1e-9)
    more = noisy.prior(0.5, 1.5).covariance - usual.prior(0.5, 1.5).covariance
    np.testing.assert_allclose(more, (0.1**2 - 0.002**2) * np.eye(3), atol=1e-12)  # a random walk of 1 s
    assert short.prior(0.5, 1.0) is None and short.prior(1.6, 1.9) is not None


def test_the_bias_and_the_clock_are_learned():
    """Samples of a wavy motion with a bias, whose stamps are late."""
    bias, late_s, waves = np.array([0.02, -0.01, 0.03]), 0.02, np.array([5.0, 7.0, 9.0])
    stamps = np.arange(0, 8, 0.005)
    rates = np.sin(np.outer(stamps - late_s, waves)) + bias
    gyroscope = dynfilter.Gyroscope(kept_s=math.inf)
    assert gyroscope.bias_sigma == 0.02 and gyroscope.offset == 0 and (gyroscope.bias == 0).all()
    first_sigma = gyroscope.offset_sigma
    gyroscope.add(stamps, rates)
    pose, poses, step = np.eye(3), [np.eye(3)], 0.001
    for t in np.arange(0, 6, step):  # R_world_camera, by small turns
        pose = pose @ turn(step * np.sin((t + step / 2) * waves))
        poses.append(pose)
    for k in range(0, 5900, 33):
        gyroscope.observe(k * step, (k + 33) * step, poses[k + 33].T @ poses[k])
    np.testing.assert_allclose(gyroscope.bias, bias, atol=1e-3)
    assert gyroscope.offset == pytest.approx(late_s, abs=1e-3)
    assert gyroscope.bias.shape == (3,) and 0 < gyroscope.bias_sigma < 0.02 and 0 < gyroscope.offset_sigma < first_sigma
    true = poses[5050].T @ poses[5000]
    np.testing.assert_allclose(gyroscope.prior(5.0, 5.05).rotation, true, atol=1e-3)


class Told(dynfilter.Filter, needs="matches", history_frames=2):
    """Keeps the priors of its matches."""

    def apply(self, evidence, votes):
        self.last, self.older = (evidence.motion_prior(evidence.match(gap)) for gap in (1, 2))


def told(prior):
    scene, spy = dynfilter.ExactScene("general", matches=False, descriptors=True), Told()
    pipeline = dynfilter.Pipeline(spy)
    for k in range(4):
        pipeline.before_pose(**scene.frame(k).arguments(), motion_prior=prior)
    return spy


def test_a_filter_sees_the_prior_of_its_match():
    R = turn((0, 0, 0.01))
    spy = told(dynfilter.MotionPrior(R, covariance(6), (1, 2, 3)))
    np.testing.assert_array_equal(spy.last.rotation, R)
    np.testing.assert_array_equal(spy.last.translation, [1, 2, 3])
    np.testing.assert_array_equal(spy.last.covariance, covariance(6))
    assert spy.older is None
    spy = told(dynfilter.MotionPrior(R, covariance(3), frame_id=1))  # in frame 3
    assert spy.last is None and spy.older.frame_id == 1 and spy.older.translation is None
    assert told(None).last is None


@pytest.mark.parametrize("call", ["before_pose", "after_pose", "at_keyframe"])
def test_calls_take_a_prior(call):
    judge = getattr(dynfilter.Pipeline("dynfilter"), call)
    assert len(judge(PLACES, timestamp=0.0, motion_prior=dynfilter.MotionPrior(np.eye(3), SMALL))) == len(PLACES)
    for wrong, got in ((np.eye(3), r"an array of shape \(3, 3\) and type float64"), (5, "a int")):
        with pytest.raises(ValueError, match=f"^motion_prior: expected a dynfilter.MotionPrior, got {got}$"):
            judge(PLACES, timestamp=0.1, motion_prior=wrong)


def test_the_true_motion_does_no_harm():
    scene, pipeline = dynfilter.ExactScene("general"), dynfilter.Pipeline("dynfilter")
    for k in range(8):
        frame = scene.frame(k)
        motion = np.linalg.inv(frame.pose) @ scene.frame(k - 1).pose if k > 0 else np.eye(4)
        prior = dynfilter.MotionPrior(motion[:3, :3], 1e-6 * np.eye(6), motion[:3, 3])
        verdict = pipeline.before_pose(**frame.arguments(), motion_prior=prior)
    assert not verdict.keep[frame.dynamic].any() and verdict.keep[frame.static].mean() > 0.95


def test_a_file_of_samples(tmp_path):
    file = tmp_path / "imu.txt"
    file.write_text("# timestamp wx wy wz\n12.5 1 2 3\n12.505 4 5 6\n")
    stamps, omegas, R_camera_body = dynfilter.read_gyroscope(str(file))
    np.testing.assert_array_equal(stamps, [12.5, 12.505])
    np.testing.assert_array_equal(omegas, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(R_camera_body, np.eye(3))
    with pytest.raises(dynfilter.IoError, match="none.txt: no such file"):
        dynfilter.read_gyroscope(str(tmp_path / "none.txt"))


# ---- runs

needs_odometry = pytest.mark.skipif(not dynfilter.has_odometry, reason="built without the odometry")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("motion") / "walking"
    synth = [os.environ["DYNFILTER_COMMAND"], "synth", "walking_xyz", str(path), "--frames", "12", "--no-right"]
    subprocess.run(synth, check=True, capture_output=True)
    return path


@pytest.fixture(scope="module")
def wheels(folder, tmp_path_factory):
    file = tmp_path_factory.mktemp("wheels") / "wheels.txt"
    dynfilter.write_trajectory(str(file), dynfilter.Recording(folder).ground_truth())
    return file


@needs_odometry
@pytest.mark.parametrize("sensor", ["imu", "wheel_odometry"])
def test_runs_are_those_of_the_command(folder, wheels, tmp_path, tool, sensor):
    given = "auto" if sensor == "imu" else wheels
    run = [tool("DYNFILTER_COMMAND"), "run", str(folder), "--out", str(tmp_path / "out"), "--" + sensor.replace("_", "-"), str(given)]
    subprocess.run(run, check=True, capture_output=True)
    expected = json.loads((tmp_path / "out/summary.json").read_text())
    ours = dynfilter.run("dynfilter", dynfilter.Recording(folder), **{sensor: given})
    for key in ("ate_rmse_m", "precision", "recall", "static_kept"):
        assert getattr(ours, key) == pytest.approx(expected[key], abs=1e-12), key
    learned = [note for note in expected["notes"] if note.startswith("gyroscope: bias ")]
    assert [note for note in ours.notes if note.startswith("gyroscope: bias ")] == learned
    assert len(learned) == (sensor == "imu")


@needs_odometry
def test_filters_of_a_run_see_the_sensors(folder, wheels):
    """Wheels tell the true motion, and count where there is a gyroscope, too."""

    class Collects(dynfilter.Filter, needs="matches"):
        def apply(self, evidence, votes):
            if evidence.call_point == "before_pose":
                self.seen.append(evidence.motion_prior(evidence.match()))

    poses, spy = dynfilter.Recording(folder).ground_truth()[1], Collects()
    samples = folder / "imu0/data.csv"
    for sensors in ({}, {"imu": samples}, {"wheel_odometry": wheels}, {"imu": "auto", "wheel_odometry": str(wheels)}):
        spy.seen = []
        dynfilter.run(spy, dynfilter.Recording(folder), frames=4, **sensors)
        priors = spy.seen[-3:]
        assert len(priors) == 3 and all((prior is not None) == bool(sensors) for prior in priors)
        for k, prior in enumerate(priors, 1):
            if prior is None:
                continue
            motion = np.linalg.inv(poses[k]) @ poses[k - 1]
            np.testing.assert_allclose(prior.rotation, motion[:3, :3], atol=0.01 if "wheel_odometry" not in sensors else 1e-5)
            assert (prior.translation is None) == ("wheel_odometry" not in sensors)
            if prior.translation is not None:
                np.testing.assert_allclose(prior.translation, motion[:3, 3], atol=1e-4)


@needs_odometry
def test_priors_of_a_run(folder):
    """Each frame but the first has one, in reverse too, and the true turn is within what it says."""
    sequence = dynfilter.Recording(folder)
    poses = sequence.ground_truth()[1]
    for order in (range(12), range(11, -1, -1)):
        priors, last = dynfilter._core._MotionPriors(str(folder), "auto", ""), None
        for k in order:
            prior = priors.next(sequence[k].timestamp)
            assert (prior is None) == (last is None)
            if prior is not None:
                off = prior.rotation @ (np.linalg.inv(poses[k]) @ poses[last])[:3, :3].T
                vector = np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]]) / 2
                assert vector @ np.linalg.solve(prior.covariance, vector) < 25  # of about 3
            priors.tracked(poses[k])
            last = k


@needs_odometry
def test_comparisons_take_sensors(folder):
    table = dynfilter.compare(["none", "dynfilter"], [dynfilter.Recording(folder), "general"], imu="auto", frames=6, pictures=False)
    assert [any(note.startswith("gyroscope: ") for note in run.notes) for run in table] == [True, True, False, False]
    assert dynfilter.run("none", dynfilter.Recording(folder), imu="auto", frames=4, reverse=True).frames == 4


@needs_odometry
def test_sensors_that_cannot_be_read(folder, rendered, tmp_path):
    with pytest.raises(dynfilter.IoError, match="none.csv: no such file"):
        dynfilter.run("none", rendered, imu=tmp_path / "none.csv")
    with pytest.raises(dynfilter.IoError, match="none.txt"):
        dynfilter.run("none", rendered, wheel_odometry=str(tmp_path / "none.txt"))
    with pytest.raises(dynfilter.Error, match="^imu: `auto` is the gyroscope of a recording's folder, and `walking_xyz` has none"):
        dynfilter.run("none", rendered, imu="auto")
    for argument in ("imu", "wheel_odometry"):
        with pytest.raises(ValueError, match=f"^{argument}: expected a file, got a int"):
            dynfilter.run("none", rendered, **{argument: 5})
    bare = tmp_path / "bare"
    bare.mkdir()
    for name in os.listdir(folder):
        if name != "imu0":
            (bare / name).symlink_to(folder / name)
    with pytest.raises(dynfilter.IoError, match="has neither imu0/data.csv nor imu.txt: give the gyroscope's file"):
        dynfilter.run("none", dynfilter.Recording(bare), imu="auto")


@needs_odometry
def test_the_odometry_takes_a_prior(rendered):
    frame = rendered[0]
    odometry = dynfilter.Odometry(frame.camera)
    given = dict(depth=frame.depth, depth_unit_m=frame.depth_unit_m)
    prior = dynfilter.MotionPrior(np.eye(3), SMALL)
    assert odometry.process(frame.grey, timestamp=0.0, motion_prior=prior, **given).state == "tracked"
    with pytest.raises(ValueError, match="^motion_prior: expected a dynfilter.MotionPrior, got an array"):
        odometry.process(frame.grey, timestamp=0.1, motion_prior=np.eye(3), **given)
