# SPDX-License-Identifier: MIT
"""Filters written in Python."""

from dataclasses import dataclass
from typing import List, Literal

import numpy as np
import pytest

import dynfilter


@dataclass
class TooNear(dynfilter.Filter, name="py_too_near", needs="depth"):
    """Rejects features nearer than a limit.

    More text.
    """

    min_depth_m: float = dynfilter.param(0.5, unit="m", min=0, max=10, doc="nearer features are dynamic")
    count: int = 3
    on: bool = True
    mode: Literal["a", "b"] = "a"
    classes: List[str] = dynfilter.param(["person"])

    def apply(self, evidence, votes):
        if self.on:
            votes.by_distance(self.min_depth_m - evidence.depths_m, 0.0)


def pipeline_of(stage):
    return dynfilter.Pipeline(f"pipeline:\n  floor: {{ min_features: 0 }}\n  before_pose:\n    - {stage}\n")


def judged(source, depth_m):
    places = np.float32([[10 * i, 10] for i in range(len(depth_m))])
    pipeline = source if isinstance(source, dynfilter.Pipeline) else dynfilter.Pipeline(source)
    return pipeline.before_pose(places, timestamp=0, depth_m=depth_m, min_features=0)


def test_stands_in_yaml_with_its_parameters():
    verdict = judged(pipeline_of("py_too_near: { min_depth_m: 2, count: 5, mode: b, classes: [cat, dog] }"), [1, 3, np.nan])
    assert list(verdict.decision) == [dynfilter.DYNAMIC, dynfilter.STATIC, dynfilter.UNKNOWN]
    assert verdict.reasons[0] == "py_too_near"
    assert list(judged(pipeline_of("py_too_near: { min_depth_m: 2, on: false }"), [1, 3]).decision) == [0, 0]
    assert list(judged(pipeline_of("py_too_near"), [0.4, 1]).decision) == [2, 1]


def test_beside_compiled_filters():
    text = "any: [ epipolar, { py_too_near: { min_depth_m: 2 } } ]"
    verdict = judged(pipeline_of(text), [1, 3])
    assert verdict.stages == ["sequence", "any", "epipolar", "py_too_near"]
    assert not verdict.keep[0] and verdict.keep[1]


@pytest.mark.parametrize(
    "parameters, message",
    [
        ("min_depth: 2", "py_too_near: unknown key `min_depth` .did you mean `min_depth_m`..; known keys: min_depth_m, count, on, mode, classes"),
        ("min_depth_m: 11", "min_depth_m: expected 0 to 10, got `11`"),
        ("min_depth_m: near", "min_depth_m: expected a number"),
        ("count: 1.5", "count: expected a whole number"),
        ("on: maybe", "on: expected"),
        ("mode: c", "mode: expected one of a, b, got `c`"),
    ],
)
def test_wrong_parameters_name_their_path(parameters, message):
    with pytest.raises(dynfilter.ConfigError, match=message) as error:
        pipeline_of(f"py_too_near: {{ {parameters} }}")
    assert error.value.path.startswith("pipeline.before_pose[0].py_too_near")


def test_a_class_may_check_its_parameters():
    @dataclass
    class Ordered(dynfilter.Filter):
        low: float = 1.0
        high: float = 2.0

        def __post_init__(self):
            if self.low > self.high:
                raise ValueError("low is above high")

    with pytest.raises(dynfilter.ConfigError, match=r"before_pose\[0\].ordered: low is above high"):
        pipeline_of("ordered: { low: 3 }")


def test_its_card():
    card = next(card for card in dynfilter.filter_cards() if card.name == "py_too_near")
    assert card.summary == "Rejects features nearer than a limit" and card.needs == "depth"
    first = card.parameters[0]
    assert (first.name, first.type, first.unit, first.default, first.range) == (
        "min_depth_m", "number", "m", "0.5", "0 to 10",
    )  # fmt: skip
    assert [p.default for p in card.parameters] == ["0.5", "3", "true", "a", "[person]"]


def test_missing_inputs_skip_it():
    verdict = dynfilter.Pipeline(TooNear()).before_pose(np.zeros((2, 2)), timestamp=0)
    assert verdict.report.stages[0].skipped and "depth" in verdict.report.stages[0].note


def test_an_exception_reaches_the_caller_and_the_pipeline_goes_on():
    class Fails(dynfilter.Filter):
        def apply(self, evidence, votes):
            if evidence.frame_id == 1:
                raise KeyError("no such thing")
            votes.dynamic(np.full(len(evidence), True))

    pipeline, places = dynfilter.Pipeline(Fails()), 20.0 * np.stack(np.divmod(np.arange(200), 20), axis=1)
    assert pipeline.before_pose(places, timestamp=0.0).keep.sum() == 50  # the floor
    with pytest.raises(KeyError, match="no such thing") as error:
        pipeline.before_pose(places, timestamp=0.1)
    assert "apply" in [entry.name for entry in error.traceback]  # the line of the filter is in the traceback
    assert pipeline.before_pose(places, timestamp=0.2).keep.sum() == 50


def test_votes():
    class Casts(dynfilter.Filter):
        def apply(self, evidence, votes):
            votes.dynamic(np.array([True, False, False, False, False]), 0.75)
            votes.static([1, 2], [0.25, 0.125])
            votes.suspect([3])
            votes.note("a note")
            assert list(votes.decision) == [2, 1, 1, 0, 0] and len(votes) == 5
            for where in ([5], [-1], np.zeros(4, bool), [0.5]):
                with pytest.raises(ValueError, match="^where"):
                    votes.dynamic(where)
            with pytest.raises(ValueError, match="^suspicion"):
                votes.dynamic([1, 2], [0.5])
            with pytest.raises(ValueError, match="^distance"):
                votes.by_distance([1, 2], 3)

    verdict = dynfilter.Pipeline(Casts()).before_pose(np.zeros((5, 2)), timestamp=0, min_features=0)
    np.testing.assert_array_equal(verdict.suspicion, np.float32([0.75, 0.25, 0.125, 0.5, 0.5]))
    moves, rests = np.float32([0.75, 0.25, 0.125]) ** 2, np.float32([0.25, 0.75, 0.875]) ** 2
    expected = np.where(verdict.keep[:3], rests / (moves + rests), 0)
    np.testing.assert_allclose(verdict.weight, [*expected, 1, 1], rtol=1e-6)
    assert list(verdict.prior) == [False, False, False, True, False]
    assert "a note" in verdict.report.stages[0].note


def test_by_distance_is_the_toolkits_suspicion():
    class Far(dynfilter.Filter):
        def apply(self, evidence, votes):
            votes.by_distance([0.0, 1.0, 3.0, np.nan], 1.0)

    verdict = pipeline_of("far").before_pose(np.zeros((4, 2)), timestamp=0)
    np.testing.assert_array_equal(verdict.suspicion, np.float32([0, 0.5, 0.75, 0.5]))  # d / (d + limit)
    assert list(verdict.decision) == [1, 1, 2, 0]


def test_evidence_of_matches_and_models():
    class Twin(dynfilter.Filter, needs="matches depth camera", optional="pose", history_frames=3):
        """The epipolar filter of the toolkit, again."""

        def apply(self, evidence, votes):
            match = evidence.match()
            self.frame_id = match.frame_id
            model = evidence.two_view(match)
            votes.by_distance(model.distance_px, 1.0)
            self.model, self.motion = model, evidence.rigid_motion(match)
            self.host = evidence.host_motion(match)
            self.tracks = evidence.tracks(3)
            self.found = match.found
            self.off_px = np.linalg.norm(evidence.undistorted_pixels - match.pixels, axis=1)

    scene = dynfilter.ExactScene("general", pixel_noise_px=0.2, poses=True)
    twin = Twin()
    ours, theirs = dynfilter.judge(twin, scene, 6), dynfilter.judge("epipolar", scene, 6)
    np.testing.assert_array_equal(ours.decision, theirs.decision)
    assert ours.recall == theirs.recall > 0.9
    assert twin.frame_id == 5 and twin.model.kind == "fundamental" and twin.model.F.shape == (3, 3)
    np.testing.assert_allclose(twin.motion, twin.host, atol=0.01)  # static points and the true poses agree
    truth = np.linalg.inv(scene.frame(6).pose) @ scene.frame(5).pose
    np.testing.assert_allclose(twin.host, truth, atol=1e-9)
    assert twin.tracks.shape == (len(ours.decision), 4, 2)
    moved = np.linalg.norm(twin.tracks[:, 0] - twin.tracks[:, 1], axis=1)
    np.testing.assert_allclose(moved[twin.found], twin.off_px[twin.found], atol=1e-3)


def test_state_and_reset():
    class Counts(dynfilter.Filter):
        frames = 0

        def apply(self, evidence, votes):
            self.frames += 1

        def reset(self):
            self.frames = 0

    counts = Counts()
    pipeline = dynfilter.Pipeline(counts)
    for t in range(3):
        pipeline.before_pose(np.zeros((1, 2)), timestamp=t / 30)
    assert counts.frames == 3
    pipeline.reset()
    assert counts.frames == 0


def test_evidence_ends_with_the_frame():
    class Keeps(dynfilter.Filter):
        def apply(self, evidence, votes):
            self.evidence, self.votes, self.match = evidence, votes, evidence.match()
            self.pixels = evidence.pixels

    keeps = Keeps()
    dynfilter.Pipeline(keeps).before_pose(np.float32([[1, 2]]), timestamp=0)
    assert keeps.pixels.tolist() == [[1, 2]]  # arrays are copies
    for use in (lambda: keeps.evidence.pixels, lambda: keeps.votes.dynamic([0]), lambda: keeps.match.found):
        with pytest.raises(RuntimeError, match="copy what you keep"):
            use()


def test_names():
    class SomeIdea(dynfilter.Filter):
        pass

    assert SomeIdea.name == "some_idea" and "some_idea" in [card.name for card in dynfilter.filter_cards()]
    with pytest.raises(dynfilter.ConfigError, match="`epipolar` comes with dynfilter"):

        class Taken(dynfilter.Filter, name="epipolar"):
            pass

    with pytest.raises(ValueError, match="needs: expected one of grey, depth.*got `colour`"):

        class Wants(dynfilter.Filter, needs="colour"):
            pass

    class SomeIdea(dynfilter.Filter):  # noqa: F811: as when a cell of a notebook is run again
        """The second one."""

    card = next(card for card in dynfilter.filter_cards() if card.name == "some_idea")
    assert card.summary == "The second one"


def test_apply_must_be_written():
    class Empty(dynfilter.Filter):
        pass

    with pytest.raises(NotImplementedError, match="Empty.apply"):
        dynfilter.judge(Empty(), dynfilter.ExactScene("general"))


def test_same_figures_as_the_compiled_twin():
    """One idea, twice: the filter of the tutorial in C++ and here."""

    @dataclass
    class NearTwin(dynfilter.Filter, needs="depth"):
        min_depth_m: float = 2.0

        def apply(self, evidence, votes):
            votes.dynamic(evidence.depths_m < self.min_depth_m)

    scene = dynfilter.ExactScene("general")
    frame = scene.frame(8)
    judgement = dynfilter.judge(NearTwin(), scene)
    near = frame.depth_m < 2
    np.testing.assert_array_equal(judgement.decision == dynfilter.DYNAMIC, near)
    assert judgement.recall == near[frame.dynamic].mean()
    assert judgement.static_kept == 1 - near[frame.static].mean()
