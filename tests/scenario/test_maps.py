"""Floor plans: files of ROS maps and of polygons become cells and points, and each wrong file is an error."""

from __future__ import annotations

import base64
import io
import json
import struct
import zlib
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from feasibee import Scenario, ScenarioError
from feasibee.scenario.cells import cells_of, digest_of, image_of
from feasibee.scenario.fields import Arena, Place
from feasibee.scenario.ground import plan_of
from feasibee.scenario.maps import with_plans
from feasibee.scenario.tables import hash_of
from feasibee.simulation.plan import study_of

HALL = """\
image: hall.pgm
resolution: 0.5
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
GREY = np.array([[0, 0, 0, 0], [0, 254, 206, 0], [0, 254, 205, 0]], np.uint8)
"""Walls, free cells, 206 just free (0.192), 205 just not (0.1961)."""
CLOSED = ["####", "#..#", "#.##"]
SQUARE = [[0, 3], [1, 3], [1, 4], [0, 4], [0, 3]]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder with a map of three rows and four columns."""
    monkeypatch.chdir(tmp_path)
    Path("hall.yaml").write_text(HALL)
    save(GREY, "hall.pgm")
    return tmp_path


def save(grey, name):
    Image.fromarray(grey).save(name)


def geojson(*rings):
    Path("shape.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": list(rings)}))


def drawn(cells):
    return ["".join(".#"[int(each)] for each in row) for row in cells[::-1]]


def plan(side=None, metres=None, **place):
    """Return the cells of a place whose files are read, without the rules for a swarm in it."""
    table, problems = with_plans(place, side, metres)
    assert not problems
    return plan_of(Place.model_validate(table), Arena(side=side or 20.0).size)


def told(**tables):
    with pytest.raises(ScenarioError) as error:
        Scenario(**tables)
    return str(error.value)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def bomb(width, height):
    """Return a PNG that says it has so many pixels, in a hundred bytes."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")


# --- Maps and polygons ---


def hall(**lines):
    """Return the text of a map's YAML file, with other lines than the usual ones."""
    kept = [each for each in HALL.splitlines() if each.partition(":")[0] not in lines]
    return "\n".join([*kept, *(f"{key}: {value}" for key, value in lines.items())])


def mask(rows, columns):
    """Return an image that is unknown, but for two dark corners."""
    grey = np.full((rows, columns), 205, np.uint8)
    grey[0, 0] = grey[-1, -1] = 0
    return grey


def polygon(*rings):
    return {"type": "Polygon", "coordinates": list(rings)}


MAP, SHAPE = {"map": "hall.yaml"}, {"map": "shape.geojson", "cell": 0.5}
WALLS, NONE = {"walls": CLOSED}, {"walls": ["...."] * 3}
OPAQUE = np.dstack([np.full_like(GREY, 254)] * 3 + [(GREY > 205) * np.uint8(255)])
OUTER, HOLE = [[0, 1], [4, 1], [4, 3], [0, 3]], [[0.5, 1.5], [3.5, 1.5], [3.5, 2.5], [0.5, 2.5]]
LOW = polygon([[1, 1], [3, 1], [3, 1.5], [1, 1.5]])
INSIDE = ["........", "..####..", "........", "........"]
ROUND = polygon([[-1, 2], [0.5, 2], [0.5, 3.5], [-1, 3.5]], [[-0.5, 2.5], [0, 2.5], [0, 3], [-0.5, 3]])
FEATURE = {"type": "Feature", "properties": {"type": "Point"}, "geometry": polygon(SQUARE)}
BOTH = {"type": "FeatureCollection", "features": [FEATURE, {"type": "Feature", "geometry": polygon(SQUARE)}]}
MASKS = {
    # of the map's frame: the origin, rows and columns, and the cells that are no-go
    "in the same frame": ([-1.0, 2.0], (3, 4), ["#...", "....", "...#"]),
    "moved": ([-0.5, 2.5], (3, 4), ["....", "....", "...."]),
    "moved back": ([-1.5, 2.0], (3, 4), ["....", "....", "..#."]),
    "larger": ([-1.5, 1.5], (5, 6), ["....", "....", "...."]),
    "a fifth of a metre off": ([-1.2, 2.1], (3, 4), ["#...", "....", "...#"]),
    "smaller": ([0.0, 2.5], (1, 1), ["....", "..#.", "...."]),
}
PLANS = {
    # files, fields of the place, and what is drawn of its cells
    "a map": ({}, MAP, {**WALLS, "keepout": ["...."] * 3}),
    "cells at a threshold": (  # grey 204 is 0.2 and 102 is 0.6, exactly
        {
            "hall.pgm": np.array([[205, 204, 203, 103, 102]], np.uint8),
            "hall.yaml": hall(free_thresh=0.2, occupied_thresh=0.6),
        },
        {**MAP, "keepout": "hall.yaml"},
        {"walls": ["..###"], "keepout": ["....#"]},
    ),
    "white walls": ({"hall.pgm": 255 - GREY, "hall.yaml": hall(negate=1)}, MAP, WALLS),
    "white walls, in words": ({"hall.pgm": 255 - GREY, "hall.yaml": hall(negate="true")}, MAP, WALLS),
    "colours": ({"a.png": np.dstack([GREY] * 3), "hall.yaml": hall(image="a.png", mode="scale")}, MAP, WALLS),
    "a transparent cell": ({"a.png": OPAQUE, "hall.yaml": hall(image="a.png")}, MAP, WALLS),
    "a text, with the map server's defaults": (
        {
            "t.pgm": "P2\n# by hand\n4 1\n# grey\n255\n0 254 192 191\n",
            "hall.yaml": "image: t.pgm\nresolution: 5e-2",
        },
        MAP,
        {"walls": ["#..#"]},
    ),
    "a mask without a map": (
        {"hall.yaml": hall(origin="[0.5, 0.0]")},
        {"keepout": "hall.yaml", "cell": 0.5, "side": [2.0, 1.5]},
        {**NONE, "keepout": [".###", ".#..", ".#.."]},
    ),
    **{
        f"a mask {where}": (
            {"mask.pgm": mask(*shape), "mask.yaml": hall(image="mask.pgm", origin=[*origin, 0.0])},
            {**MAP, "keepout": "mask.yaml"},
            {**WALLS, "keepout": expected},
        )
        for where, (origin, shape, expected) in MASKS.items()
    },
    "polygons, as large as they are": (
        {"shape.geojson": {"type": "MultiPolygon", "coordinates": [[OUTER, HOLE]]}},
        SHAPE,
        {"walls": ["########", "#......#", "#......#", "########"]},
    ),
    "a polygon": ({"shape.geojson": LOW}, SHAPE, {"walls": ["####"]}),
    "a polygon in an arena": ({"shape.geojson": LOW}, {**SHAPE, "side": [4.0, 2.0]}, {"walls": INSIDE}),
    "a polygon that is no-go": (
        {"shape.geojson": LOW},
        {"keepout": "shape.geojson", "cell": 0.5, "side": [4.0, 2.0]},
        {"keepout": INSIDE},
    ),
    **{  # the map's lower left cell begins at -1, 2; cells are of half a metre
        f"polygons in metres, units of {metres}": (
            {"shape.geojson": ROUND},
            {**MAP, "keepout": "shape.geojson", "zones": {"dock": "shape.geojson"}, "metres": metres},
            {"keepout": ["###.", "#.#.", "###."], "dock": ["###.", "#.#.", "###."]},
        )
        for metres in (None, 0.5, 0.1)
    },
    **{
        each["type"]: ({"shape.geojson": each}, {"map": "shape.geojson"}, {"walls": ["#" * 10] * 10})
        for each in (polygon(SQUARE), FEATURE, BOTH)
    },
}


@pytest.mark.parametrize("what", PLANS)
def test_files_become_the_cells_of_a_plan(folder, what):
    """A cell of a map is open if it is surely free; of a mask, only dark cells are no-go."""
    files, place, expected = PLANS[what]
    for name, content in files.items():
        if isinstance(content, np.ndarray):
            save(content, name)
        else:
            Path(name).write_text(content if isinstance(content, str) else json.dumps(content))
    found = plan(**place)
    cells = {"walls": found.walls, "keepout": found.keepout, **found.zones}
    assert {key: drawn(cells[key]) for key in expected} == expected


def test_metres_become_units_and_a_side_in_single_precision_is_mended(folder):
    for metres, cell in ((None, 0.05), (0.5, 0.1), (0.3, 0.1666667)):
        Path("hall.yaml").write_text(hall(resolution=0.05000000074505806))
        found = plan(map="hall.yaml", metres=metres)
        assert found.cell == Fraction(str(cell))
        assert found.walls.shape == (3, 4)


# --- The complete form ---


@pytest.fixture
def rooms(folder):
    """Make each cell of the map 4 metres wide: there is room for a swarm. Return the place's table."""
    save(np.kron(GREY, np.ones((8, 8), np.uint8)), "hall.pgm")
    geojson([[4, 6], [7, 6], [7, 9], [4, 9], [4, 6]])
    return {"map": "hall.yaml", "keepout": "hall.yaml", "zones": {"dock": "shape.geojson"}}


def test_a_map_sets_the_arena_and_its_files_are_found_from_the_scenarios_folder(rooms, folder, monkeypatch):
    place = 'map = "hall.yaml"\nkeepout = "hall.yaml"\nzones.dock = "shape.geojson"'
    Path("a.toml").write_text(f'robots.zone = "dock"\n[place]\n{place}')
    monkeypatch.chdir("/")
    scenario = Scenario.read(folder / "a.toml")
    assert scenario.arena.size == (16.0, 12.0)
    assert scenario.arena.boundary == "walls"
    assert scenario.place.zones == {"dock": (((5.0, 4.0), (8.0, 4.0), (8.0, 7.0), (5.0, 7.0)),)}
    assert "side" not in scenario.model_dump(exclude_unset=True).get("arena", {})
    sweep = {"place.keepout": ["hall.yaml"], "place.zones.yard": ["shape.geojson"]}
    study = study_of({"file": "a.toml", "sweep": sweep}, folder)
    assert study.points[0].scenario.place.zones["yard"] == scenario.place.zones["dock"]


def test_the_complete_form_has_all_and_needs_no_file(rooms):
    scenario = Scenario(place=rooms, robots={"zone": "dock"})
    for each in ("hall.yaml", "hall.pgm", "shape.geojson"):
        Path(each).unlink()
    again = Scenario.from_toml(scenario.to_toml())
    assert again == scenario
    assert again.hash == scenario.hash
    assert again.to_toml() == scenario.to_toml()
    assert (scenario.replace({"run.steps": 5}).plan.walls == scenario.plan.walls).all()
    assert Scenario.model_validate_json(scenario.model_dump_json(exclude_unset=True)) == scenario


def test_the_hash_is_that_of_the_cells_however_they_are_encoded(rooms):
    scenario = Scenario(place={"map": "hall.yaml"})
    cells, file = cells_of(scenario.place.map.image), io.BytesIO()
    Image.fromarray(~cells[::-1]).convert("L").save(file, "PNG", compress_level=0)
    other = {"cell": 0.5, "image": base64.b64encode(file.getvalue()).decode()}
    assert other["image"] != scenario.place.map.image
    assert Scenario(place={"map": other}).hash == scenario.hash
    other = cells.copy()
    other[12, 12] ^= True
    for changed in (other, cells[:-1]):
        assert Scenario(place={"map": {"cell": 0.5, "image": image_of(changed)}}).hash != scenario.hash
    assert digest_of(image_of(cells)) != digest_of(image_of(cells.reshape(32, 24)))
    tables = scenario.to_dict()
    tables["place"]["map"]["image"] = "no image"
    assert hash_of(tables) != scenario.hash


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32))
def test_cells_are_the_same_after_they_are_encoded(rows, columns, seed):
    cells = np.random.default_rng(seed).random((rows, columns)) < 0.5
    assert (cells_of(image_of(cells)) == cells).all()


def test_cells_are_closed_where_a_pixel_is_darker_than_half():
    Image.fromarray(np.array([[127, 128]], np.uint8)).save(file := io.BytesIO(), "PNG")
    assert cells_of(base64.b64encode(file.getvalue()).decode()).tolist() == [[True, False]]


# --- Errors ---

BOMB = "".join(f"a{k}: &a{k + 1} [*a{k}, *a{k}]\n" for k in range(30))
"""A billion values in 30 lines, once *a30 is written out."""
ORIGIN = "[-1.0, 2.0, 0.0]"
YAML_ERRORS = [
    # a part of the file, what stands there instead, and the rule that it breaks
    (ORIGIN, "[-1.0, 2.0, 0.1]", "origin has yaw 0.1, which must be 0; turn the image"),
    (ORIGIN, "[1.0]", "origin ['1.0'] must be three numbers"),
    (ORIGIN, "[left, low, 0]", "must be three numbers"),
    ("resolution", "resolutions", "resolution is missing in this file; write resolution: 0.05"),
    ("0.5\n", "0\n", "resolution '0' must be a number from 1e-06 to 1000000"),
    ("0.5\n", "nan\n", "resolution 'nan' must be a number"),
    ("0.5\n", "[1]\n", "resolution ['1'] must be a number"),
    ("0.196", "0.7", "free_thresh must be below occupied_thresh"),
    ("0.65", "65", "occupied_thresh '65' must be a number from 0 to 1"),
    ("negate: 0", "mode: raw", "mode 'raw' must be trinary or scale"),
    ("negate: 0", "negate: perhaps", "negate 'perhaps' must be 0 or 1"),
    ("image", "images", "image is missing in this file; write image: hall.pgm"),
    ("hall.pgm", "''", "image '' must be a file's name"),
    ("hall.pgm", "door.pgm", "image 'door.pgm' can't be read: No such file"),
    ("hall.pgm", "hall.yaml", "image 'hall.yaml' must be a PNG or PGM image"),
    ("negate: 0", "negate: [0", "isn't YAML, line 5"),
    (HALL, f"resolution: 1\nb: &a0 [9]\n{BOMB}image: *a30", "image [[[[...], [...]]"),
    (HALL, "- 1", "must be a table of image, resolution and origin"),
    (HALL, "#" * 70_000, "must have at most 65536 characters"),
    (HALL, "[" * 500, "isn't YAML"),
    (HALL, "!!python/object/apply:os.system ['touch ran']", "must be a table of image"),
    (HALL, "&a {image: *a}", "isn't YAML"),
]


@pytest.mark.parametrize(("old", "new", "rule"), YAML_ERRORS)
def test_a_wrong_yaml_file_is_told(folder, old, new, rule):
    Path("hall.yaml").write_text(HALL.replace(old, new))
    for key in ("map", "keepout"):
        text = told(place={key: "hall.yaml"}, arena={"boundary": "walls"})
        assert text.startswith(f"place.{key} = 'hall.yaml': "), text
        assert rule in text
    assert not Path("ran").exists()


LARGE = "must be at most 4096 x 4096 pixels"
IMAGES = {
    "200 million cells": (bomb(20_000, 10_000), LARGE),
    "100 million cells": (bomb(12_000, 10_000), LARGE),
    "a column too many": (bomb(4097, 1), f"{LARGE}, not 4097 x 1"),
    "a PNG with little": (bomb(4096, 4096), "is damaged: it can't be decoded"),
    "a PGM that ends": (b"P5 10 10 255\n123", "is damaged: it can't be decoded"),
    "16 bits": (b"P5 1 1 65535\n\0\0", "must have at most 8 bits per colour"),
    "a JPEG": (b"\xff\xd8\xff" + bytes(50), "must be a PNG or PGM image"),
}


@pytest.mark.parametrize("what", IMAGES)
def test_an_image_that_is_no_map_is_told_before_it_is_decoded(folder, what):
    data, rule = IMAGES[what]
    Path("hall.pgm").write_bytes(data)
    assert f"place.map = 'hall.yaml': image 'hall.pgm' {rule}" in told(place={"map": "hall.yaml"})
    image = base64.b64encode(data).decode()
    text = told(place={"map": {"cell": 0.5, "image": image}})
    assert text.startswith("place.map.image = ")
    assert (rule if data[:4] == b"\x89PNG" else "must be a PNG in base64") in text


NO_POLYGON, FEW = "must be a Polygon or MultiPolygon, not", "of 3 or more points"
SHAPES = [
    ("{", "isn't JSON: Expecting property name"),
    ("[" * 100_000, "is nested too deeply"),
    ("5", f"{NO_POLYGON} None"),
    ('{"type": "Point", "coordinates": [1, 2]}', f"{NO_POLYGON} 'Point'"),
    ('{"type": "FeatureCollection"}', "features None must be a list"),
    ('{"type": "FeatureCollection", "features": []}', "has no polygon"),
    ('{"type": "Feature", "geometry": {"type": "Polygon", "coordinates": []}}', FEW),
    ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]}', FEW),
    ('{"type": "Polygon", "coordinates": [[1, 2, 3]]}', "point 1.0 must be a list"),
    ('{"type": "Polygon", "coordinates": [[["a", 1], [1, 2], [3, 4]]]}', "must be a point of two finite"),
    ('{"type": "Polygon", "coordinates": [[[1e999, 1], [1, 2], [3, 4]]]}', "of two finite numbers"),
    ('{"type": "Polygon", "coordinates": [[[1], [1, 2], [3, 4]]]}', "of two finite numbers"),
    (
        '{"type": "FeatureCollection", "features": [{"type": "MultiPolygon", "coordinates": []},'
        ' {"type": "LineString"}]}',
        f"feature 2: {NO_POLYGON} 'LineString'",
    ),
]


@pytest.mark.parametrize(("text", "rule"), SHAPES)
def test_a_wrong_file_of_polygons_is_told(folder, text, rule):
    Path("shape.geojson").write_text(text)
    for path in ("place.map", "place.keepout", "place.zones.dock"):
        name = "shape.geojson"
        found = told(place={"zones": {"dock": name}} if "zones" in path else {path.partition(".")[2]: name})
        assert found.startswith(f"{path} = 'shape.geojson': "), found
        assert rule in found


def test_a_plan_with_too_many_cells_is_told_with_the_cell_that_would_do(folder):
    geojson([[0, 0], [4097, 0], [4097, 1]])
    assert "has 40970 x 10 cells of 0.1 units, above 4096 x 4096; set place.cell to 1.001 or more" in told(
        place={"map": "shape.geojson"}
    )
    assert plan(map="shape.geojson", cell=1.001).walls.shape == (1, 4093)


def test_all_wrong_files_are_told_together(folder):
    place = {"map": "a.yaml", "keepout": "hall.pgm", "zones": {"dock": "hall.yaml", "b": "c.geojson"}}
    lines = told(place=place, robots={"count": 0, "zone": "dock"}, tasks={"zone": "none"}).splitlines()
    starts = ["place.map = 'a.yaml': can't be read", "place.keepout = 'hall.pgm': must end with .yaml"]
    starts += [
        "place.zones.dock = 'hall.yaml': must be a file of polygons",
        "place.zones.b = 'c.geojson': can't",
    ]
    assert len(lines) == 5
    assert all(
        line.startswith(start) for line, start in zip(lines, [*starts, "robots.count = 0"], strict=True)
    )


def test_a_mask_of_another_resolution_or_elsewhere_is_told(folder):
    Path("mask.yaml").write_text(HALL.replace("0.5\n", "0.25\n"))
    rule = "must have the resolution of the place, 0.5 m, not 0.25 m; export it with 0.5 m per pixel"
    assert rule in told(place={"map": "hall.yaml", "keepout": "mask.yaml"})
    Path("mask.yaml").write_text(HALL.replace("-1.0", "-90.0"))
    assert "lies outside of the place" in told(place={"map": "hall.yaml", "keepout": "mask.yaml"})


PIECES = [*HALL.splitlines(keepends=True), "a: &a [*a]\n", "- x\n", "\t", "'", "!!x ", "{", "]", "%"]
KINDS, KEYS = (
    st.sampled_from(names.split())
    for names in ("Polygon Feature MultiPolygon FeatureCollection", "type features geometry coordinates")
)
JSON = st.recursive(
    st.none() | st.floats() | KINDS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=30,
)
STARTS = st.sampled_from([b"", b"P5 3 3 255\n", b"P2 3 3 255\n", b"\x89PNG\r\n\x1a\n", bomb(3, 3)])
CONTENTS = {
    "any.yaml": st.lists(st.sampled_from(PIECES) | st.text(max_size=8), max_size=9).map("".join),
    "any.geojson": JSON.map(json.dumps),
    "hall.pgm": st.builds(bytes.__add__, STARTS, st.binary(max_size=60)),
}


@pytest.mark.parametrize("name", CONTENTS)
@given(st.data())
def test_any_file_is_read_or_told(tmp_path_factory, name, data):
    folder, content = tmp_path_factory.getbasetemp(), data.draw(CONTENTS[name])
    given_ = content if isinstance(content, bytes) else content.encode(errors="replace")
    (folder / "any.yaml").write_text(HALL)
    (folder / name).write_bytes(given_)
    for key in ("map", "keepout"):
        path = folder / name.replace("hall.pgm", "any.yaml")
        table, problems = with_plans({key: str(path)}, None, None)
        assert problems or cells_of(table[key]["image"]).size
        assert all(each.path == f"place.{key}" and each.rule and each.remedy for each in problems)
