# SPDX-License-Identifier: MIT
import subprocess
import sys

import numpy as np
import pytest

import dynfilter

cv2 = pytest.importorskip("cv2")

SIZE = (240, 320)
GREY_STEP = 10


def write(path, images, rate_hz=25):
    height, width = images[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), rate_hz, (width, height))
    assert writer.isOpened()
    for image in images:
        writer.write(image)
    writer.release()


@pytest.fixture
def clip(tmp_path):
    """Ten frames, frame i of the grey level GREY_STEP i."""
    path = tmp_path / "clip.avi"
    write(path, [np.full((*SIZE, 3), GREY_STEP * i, np.uint8) for i in range(10)])
    return path


def test_a_video_is_a_recording(clip):
    video = dynfilter.Recording(clip)
    assert len(video) == 10 and video.sensor == "mono" and video.name == "clip.avi"
    assert video.camera.fx_px == 320 and any("guessed as 320 pixels" in note for note in video.notes)
    frames = list(video)
    assert [round(f.grey.mean() / GREY_STEP) for f in frames] == list(range(10))
    assert [f.index for f in frames] == list(range(10))
    np.testing.assert_allclose([f.timestamp for f in frames], np.arange(10) / 25, atol=1e-6)
    assert round(video[3].grey.mean() / GREY_STEP) == 3 and video[3].colour.shape == (*SIZE, 3)
    assert round(video[-1].grey.mean() / GREY_STEP) == 9
    with pytest.raises(IndexError):
        video[10]


def test_a_smaller_video_has_a_smaller_camera_and_boxes(clip, tmp_path):
    (tmp_path / "boxes.txt").write_text("0.04 0 person 0.9 10 20 30 60\n")
    video = dynfilter.Recording(clip, scale=0.5, detections=tmp_path / "boxes.txt")
    assert video[0].grey.shape == (120, 160) and video.camera.fx_px == 160 and video.camera.width_px == 160
    assert video[1].boxes[0].box == pytest.approx((5, 10, 10, 20)) and video[1].boxes[0].class_name == "person"
    with pytest.raises(ValueError, match="scale: expected a number above 0"):
        dynfilter.Recording(clip, scale=2)


def test_a_video_that_ends_early_ends_the_loop(clip):
    data = bytearray(clip.read_bytes())
    at = -1
    for _ in range(5):
        at = data.index(b"\xff\xd8\xff", at + 1)
    data[at : at + 200] = bytes(200)
    clip.write_bytes(data)
    video = dynfilter.Recording(clip)
    shown = [round(f.grey.mean() / GREY_STEP) for f in video]
    assert shown == [0, 1, 2, 3, 5, 6, 7, 8, 9]
    assert any("1 of 10 frames could not be decoded" in note for note in video.notes)
    with pytest.raises(IndexError, match="ended before"):
        video[9]


def test_images_by_a_pattern_and_what_is_no_video(clip, tmp_path):
    for name in ("2.png", "10.png", "1.png"):
        cv2.imwrite(str(tmp_path / name), np.full((12, 16), int(name[:-4]), np.uint8))
    images = dynfilter.Recording(tmp_path / "*.png", rate_hz=10)
    assert [f.grey[0, 0] for f in images] == [1, 2, 10]
    with pytest.raises(dynfilter.IoError, match="camera:97: no image comes from this camera"):
        dynfilter.Recording("camera:97")
    (tmp_path / "notes.txt").write_text("no video")
    with pytest.raises(dynfilter.IoError, match="is no video that OpenCV can read.*accepted are"):
        dynfilter.Recording(tmp_path / "notes.txt")


def test_verdicts_on_a_video_find_what_moves(tmp_path):
    """A textured square over a textured wall, from a camera that stands still."""
    random = np.random.default_rng(7)
    texture = [cv2.normalize(cv2.GaussianBlur(random.integers(0, 256, (*size, 3), np.uint8), None, 2), None, 0, 255, cv2.NORM_MINMAX)
               for size in (SIZE, (80, 80))]
    images = []
    for i in range(24):
        image = texture[0].copy()
        image[80:160, 20 + 4 * i : 100 + 4 * i] = texture[1]
        images.append(image)
    write(tmp_path / "square.avi", images)
    pipeline, orb = dynfilter.Pipeline("dynfilter"), cv2.ORB_create(600)
    for frame in dynfilter.Recording(tmp_path / "square.avi"):
        keypoints = orb.detect(frame.grey, None)
        verdict = pipeline.before_pose(keypoints, timestamp=frame.timestamp, grey=frame.grey, camera=frame.camera)
    x, y = np.array([k.pt for k in keypoints]).T
    inside = (abs(x - (60 + 4 * 23)) < 30) & (abs(y - 120) < 30)
    far = (abs(x - (60 + 4 * 23)) > 60) | (abs(y - 120) > 60)
    assert inside.sum() > 20 and (~verdict.keep[inside]).mean() > 0.8 and verdict.keep[far].mean() > 0.95


def test_a_run_without_a_camera_has_verdicts_only(clip):
    run = dynfilter.run("none", dynfilter.Recording(clip))
    assert run.frames == 10 and run.tracked_frames == 0 and len(run.trajectory[0]) == 0
    assert "the camera is not known: verdicts only, no trajectory" in run.notes
    given = dynfilter.Recording(clip, camera=dynfilter.Camera(300, 300, 160, 120, width_px=320, height_px=240))
    assert not given.camera_is_guessed
    assert not any("verdicts only" in note for note in dynfilter.run("none", given).notes)


def test_a_verdict_draws_itself():
    pipeline = dynfilter.Pipeline("none")
    grey = np.full((48, 64), 200, np.uint8)
    verdict = pipeline.before_pose(np.array([[20, 20], [40, 30]], np.float32), timestamp=0.0, grey=grey)
    shown = cv2.imdecode(np.frombuffer(verdict._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(shown, verdict.draw(grey))
    holders = sys.getrefcount(grey)
    again = pipeline.before_pose(np.array([[20, 20]], np.float32), timestamp=0.1, grey=grey)
    assert sys.getrefcount(grey) == holders  # a verdict does not keep its image
    del grey
    alone = cv2.imdecode(np.frombuffer(again._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert alone.shape == (64, 80, 3) and alone.max() > 100 and np.median(alone) < 60
    assert len(pipeline.before_pose(np.empty((0, 2), np.float32), timestamp=0.2)._repr_png_()) > 50


def test_the_command_and_python_see_the_same_frames(clip, tool):
    run = [tool("DYNFILTER_COMMAND"), "run", str(clip), "--pipeline", "none", "--json"]
    text = subprocess.run(run, check=True, capture_output=True, text=True).stdout
    assert f'"last_s": {list(dynfilter.Recording(clip))[-1].timestamp}' in text
