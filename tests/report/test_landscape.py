"""The reward over the plane as pictures: right way up, in the right colours, or not at all."""

import base64
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.report.runs import plan, write_run
from tiloilc.diag import CompileError
from tiloilc.report import read_run, render
from tiloilc.report.landscape import RAMP, coloured, png

AXIS = np.linspace(-2, 2, 20, dtype=np.float32)


def pixels(data: bytes) -> np.ndarray:
    """A PNG as `png` writes it, read by hand."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0] == zlib.crc32(
            kind + body
        )
        chunks[kind] = body
        at += 12 + length
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, -1)
    assert (rows[:, 0] == 0).all()
    return rows[:, 1:].reshape(height, width, 3)


def opinions() -> np.ndarray:
    """tanh f of two seeds over five states: 1 above and right of the middle, else −1."""
    upper = (AXIS[:, None] > 0) & (AXIS[None] > 0)
    return np.broadcast_to(np.where(upper, 1.0, -1.0), (2, 5, 20, 20)).copy()


def with_rewards(folder: Path, opinion: np.ndarray) -> Path:
    run, task = write_run(folder), plan()
    index, length = (np.array(v, float) for v in (task.stages.index, task.stages.length))
    shape = (1, 5, 1, 1)
    rewards = (index.reshape(shape) + task.train.beta * opinion) / length.reshape(shape)
    np.savez(run / "rewards.npz", x=AXIS, y=AXIS, rewards=rewards.astype(np.float32))
    return run


def section(page: str) -> str:
    found = re.search(r"<section><h2>Reward by stage.*?</section>", page, re.DOTALL)
    return found.group(0) if found else ""


def test_a_png_is_what_was_drawn() -> None:
    drawn = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    assert np.array_equal(pixels(png(drawn)), drawn)


def test_colours_run_from_avoided_to_sought() -> None:
    found = coloured(np.array([[-1.0, 0.0, 1.0, 3.0]]))
    assert found[0].tolist() == [list(RAMP[0]), list(RAMP[2]), list(RAMP[-1]), list(RAMP[-1])]


def test_each_stage_has_a_picture_the_right_way_up(tmp_path: Path) -> None:
    shown = section(render([read_run(with_rewards(tmp_path / "a", opinions()))]))
    images = re.findall(r'href="data:image/png;base64,([^"]+)"', shown)
    assert len(images) == 3  # neither the accepting state nor the sink has one
    drawn = pixels(base64.b64decode(images[0]))
    assert drawn[0, -1].tolist() == list(RAMP[-1])  # above, right
    assert drawn[-1, -1].tolist() == drawn[0, 0].tolist() == list(RAMP[0])
    assert "reward −0.11 to 0.11" in shown
    assert "reward 0.56 to 0.78" in shown


def test_what_is_shown_is_the_mean_over_seeds(tmp_path: Path) -> None:
    opinion = opinions()
    opinion[1] *= -1
    assert section(render([read_run(with_rewards(tmp_path / "a", opinion))])) == ""  # no opinion


def test_without_rewards_there_is_no_section(tmp_path: Path) -> None:
    assert section(render([read_run(write_run(tmp_path / "a"))])) == ""


@pytest.mark.parametrize("damage", ["bytes", "shape", "nan"])
def test_damaged_rewards_are_an_error(tmp_path: Path, damage: str) -> None:
    run = with_rewards(tmp_path / "a", opinions())
    if damage == "bytes":
        (run / "rewards.npz").write_bytes(b"x")
    else:
        rewards = np.full((2, 5, 20, 19 if damage == "shape" else 20), np.nan)
        np.savez(run / "rewards.npz", x=AXIS, y=AXIS, rewards=rewards)
    with pytest.raises(CompileError, match=r"RUN701.*rewards.npz"):
        read_run(run)
