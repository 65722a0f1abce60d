"""Floor plans: files of ROS maps and of polygons become cells and points, and each wrong file is an error."""

from __future__ import annotations

import base64
import io
import json
import os
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
from feasibee.scenario.bitmaps import cells_of, digest_of, image_of
from feasibee.scenario.fields import Arena, Place
from feasibee.scenario.maps import with_plans
from feasibee.scenario.plan import plan_of
from feasibee.scenario.tables import hash_of
from feasibee.sweeps.plan import study_of

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


def geojson(*rings, kind="Polygon", name="shape.geojson"):
    Path(name).write_text(json.dumps({"type": kind, "coordinates": list(rings)}))
    return name


def drawn(cells):
    return ["".join(".#"[int(each)] for each in row) for row in cells[::-1]]


def plan(side=None, metres=None, **place):
    """Return the cells of a place whose files are read, without the rules for a swarm in it."""
    table, problems = with_plans(place, side, metres)
    assert not problems
    return plan_of(Place.model_validate(table), Arena(side=side or 20.0).size)


def walls_of(name="hall.yaml", **values):
    return drawn(plan(map=name, **values).walls)


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


# --- ROS maps ---


def test_a_map_is_read_as_navigation_reads_it(folder):
    """A cell is open if it is surely free; all others, unknown ones too, are walls."""
    found = plan(map="hall.yaml")
    assert drawn(found.walls) == CLOSED
    assert found.cell == Fraction(1, 2)
    assert not found.keepout.any()


def test_a_cell_at_a_threshold_is_free_or_occupied(folder):
    """Grey 204 is 0.2 and 102 is 0.6, exactly."""
    save(np.array([[205, 204, 203, 103, 102]], np.uint8), "hall.pgm")
    Path("hall.yaml").write_text("image: hall.pgm\nresolution: 1\nfree_thresh: 0.2\noccupied_thresh: 0.6\n")
    found = plan(map="hall.yaml", keepout="hall.yaml")
    assert drawn(found.walls) == ["..###"]
    assert drawn(found.keepout) == ["....#"]


WAYS = {
    "a PNG": ("hall.png", GREY, ""),
    "colours": ("hall.png", np.stack([GREY] * 3, axis=2), ""),
    "opaque colours": ("hall.png", np.stack([GREY, GREY, GREY, np.full_like(GREY, 255)], axis=2), ""),
    "a transparent cell": (
        "hall.png",
        np.dstack([np.full_like(GREY, 254)] * 3 + [(GREY > 205) * np.uint8(255)]),
        "",
    ),
    "white walls": ("hall.png", 255 - GREY, "negate: 1"),
    "white walls, in words": ("hall.png", 255 - GREY, "negate: true"),
    "scale": ("hall.pgm", GREY, "mode: scale"),
    "trinary": ("hall.pgm", GREY, "mode: trinary"),
}


@pytest.mark.parametrize("how", WAYS)
def test_images_and_modes_give_the_same_cells(folder, how):
    name, grey, line = WAYS[how]
    save(grey, name)
    lines = [each for each in HALL.splitlines() if each.split(":")[0] not in ("image", line.split(":")[0])]
    Path("hall.yaml").write_text("\n".join([*lines, f"image: {name}", line]))
    assert walls_of() == CLOSED


def test_a_text_pgm_with_comments_and_defaults_of_the_map_server_is_read(folder):
    Path("t.pgm").write_text("P2\n# by hand\n4 1\n# grey\n255\n0 254 192 191\n")
    Path("t.yaml").write_text("image: t.pgm\nresolution: 5e-2\n")
    assert walls_of("t.yaml") == ["#..#"]


def test_metres_become_units_and_a_side_in_single_precision_is_mended(folder):
    for metres, cell in ((None, 0.05), (0.5, 0.1), (0.3, 0.1666667)):
        Path("hall.yaml").write_text(HALL.replace("0.5\n", "0.05000000074505806\n"))
        found = plan(map="hall.yaml", metres=metres)
        assert found.cell == Fraction(str(cell))
        assert found.walls.shape == (3, 4)


MASKS = {
    "the same frame": ([-1.0, 2.0], (3, 4), ["#...", "....", "...#"]),
    "moved": ([-0.5, 2.5], (3, 4), ["....", "....", "...."]),
    "moved back": ([-1.5, 2.0], (3, 4), ["....", "....", "..#."]),
    "larger": ([-1.5, 1.5], (5, 6), ["....", "....", "...."]),
    "a fifth of a metre off": ([-1.2, 2.1], (3, 4), ["#...", "....", "...#"]),
    "smaller": ([0.0, 2.5], (1, 1), ["....", "..#.", "...."]),
}


@pytest.mark.parametrize("where", MASKS)
def test_a_mask_is_fitted_to_the_map_and_only_dark_cells_are_no_go(folder, where):
    origin, shape, expected = MASKS[where]
    grey = np.full(shape, 205, np.uint8)  # unknown
    grey[0, 0] = grey[-1, -1] = 0
    save(grey, "mask.pgm")
    text = HALL.replace("hall.pgm", "mask.pgm").replace("[-1.0, 2.0, 0.0]", f"{[*origin, 0.0]}")
    Path("mask.yaml").write_text(text)
    found = plan(map="hall.yaml", keepout="mask.yaml")
    assert drawn(found.keepout) == expected
    assert drawn(found.walls) == CLOSED


def test_a_mask_needs_no_map(folder):
    Path("mask.yaml").write_text(HALL.replace("[-1.0, 2.0, 0.0]", "[0.5, 0.0]"))
    found = plan(keepout="mask.yaml", cell=0.5, side=[2.0, 1.5])
    assert drawn(found.keepout) == [".###", ".#..", ".#.."]
    assert not found.walls.any()


# --- Polygons ---


def test_polygons_in_metres_are_moved_by_the_maps_origin(folder):
    """The map's lower left cell begins at -1, 2; cells are of half a metre."""
    geojson([[-1, 2], [0.5, 2], [0.5, 3.5], [-1, 3.5]], [[-0.5, 2.5], [0, 2.5], [0, 3], [-0.5, 3]])
    for metres in (None, 0.5, 0.1):
        place = {
            "keepout": "shape.geojson",
            "zones": {"dock": "shape.geojson", "all": [[0, 0], [99, 0], [0, 99]]},
        }
        found = plan(map="hall.yaml", metres=metres, **place)
        assert drawn(found.keepout) == drawn(found.zones["dock"]) == ["###.", "#.#.", "###."]
        assert found.zones["all"].all()


def test_a_plan_of_polygons_is_as_large_as_they_are_or_as_the_arena(folder):
    geojson(
        [[[0, 1], [4, 1], [4, 3], [0, 3]], [[0.5, 1.5], [3.5, 1.5], [3.5, 2.5], [0.5, 2.5]]],
        kind="MultiPolygon",
    )
    assert walls_of("shape.geojson", cell=0.5) == ["########", "#......#", "#......#", "########"]
    geojson([[1, 1], [3, 1], [3, 1.5], [1, 1.5]])
    assert walls_of("shape.geojson", cell=0.5) == ["####"]
    inside = ["........", "..####..", "........", "........"]
    assert walls_of("shape.geojson", cell=0.5, side=[4.0, 2.0]) == inside
    assert drawn(plan(keepout="shape.geojson", cell=0.5, side=[4.0, 2.0]).keepout) == inside


def test_features_and_collections_are_read(folder):
    square = {"type": "Polygon", "coordinates": [SQUARE]}
    feature = {"type": "Feature", "properties": {"type": "Point"}, "geometry": square}
    both = {"type": "FeatureCollection", "features": [feature, {"type": "Feature", "geometry": square}]}
    found = []
    for number, value in enumerate((square, feature, both)):
        Path(f"{number}.geojson").write_text(json.dumps(value))
        found.append(walls_of(f"{number}.geojson"))
    assert found == [["#" * 10] * 10] * 3


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


# --- Errors ---

BOMB = "".join(f"a{k}: &a{k + 1} [*a{k}, *a{k}]\n" for k in range(30))
"""A billion values in 30 lines, once *a30 is written out."""
YAML_ERRORS = {
    "yaw": ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0, 0.1]", "origin has yaw 0.1, which must be 0; turn the image"),
    "an origin of one": ("[-1.0, 2.0, 0.0]", "[1.0]", "origin ['1.0'] must be three numbers"),
    "an origin of words": ("[-1.0, 2.0, 0.0]", "[left, low, 0]", "must be three numbers"),
    "no resolution": (
        "resolution",
        "resolutions",
        "resolution is missing in this file; write resolution: 0.05",
    ),
    "a resolution of 0": ("0.5\n", "0\n", "resolution '0' must be a number from 1e-06 to 1000000"),
    "a resolution that is none": ("0.5\n", "nan\n", "resolution 'nan' must be a number"),
    "a resolution of parts": ("0.5\n", "[1]\n", "resolution ['1'] must be a number"),
    "thresholds in disorder": ("0.196", "0.7", "free_thresh must be below occupied_thresh"),
    "a threshold above 1": ("0.65", "65", "occupied_thresh '65' must be a number from 0 to 1"),
    "raw": ("negate: 0", "mode: raw", "mode 'raw' must be trinary or scale"),
    "negate": ("negate: 0", "negate: perhaps", "negate 'perhaps' must be 0 or 1"),
    "no image": ("image", "images", "image is missing in this file; write image: hall.pgm"),
    "an empty image": ("hall.pgm", "''", "image '' must be a file's name"),
    "another image": ("hall.pgm", "door.pgm", "image 'door.pgm' can't be read: No such file"),
    "a folder for an image": ("hall.pgm", ".", "image '.' can't be read: it is a directory"),
    "no picture": ("hall.pgm", "hall.yaml", "image 'hall.yaml' must be a PNG or PGM image"),
    "no YAML": ("negate: 0", "negate: [0", "isn't YAML, line 5"),
    "a bomb": (HALL, f"resolution: 1\nb: &a0 [9]\n{BOMB}image: *a30", "image [[[[...], [...]]"),
    "no table": (HALL, "- 1", "must be a table of image, resolution and origin"),
    "too long": (HALL, "#" * 70_000, "must have at most 65536 characters"),
    "nested": (HALL, "[" * 60_000, "isn't YAML"),
    "code": (HALL, "!!python/object/apply:os.system ['touch ran']", "must be a table of image"),
    "an anchor in itself": (HALL, "&a {image: *a}", "isn't YAML"),
}


@pytest.mark.parametrize("what", YAML_ERRORS)
def test_a_wrong_yaml_file_is_told(folder, what):
    old, new, rule = YAML_ERRORS[what]
    Path("hall.yaml").write_text(HALL.replace(old, new))
    for key in ("map", "keepout"):
        text = told(place={key: "hall.yaml"}, arena={"boundary": "walls"})
        assert text.startswith(f"place.{key} = 'hall.yaml': "), text
        assert rule in text
    assert not Path("ran").exists()


@pytest.mark.parametrize(
    ("place", "path"),
    [
        ({"map": "hall.yaml"}, "place.map"),
        ({"map": "hall.yaml", "keepout": "hall.yaml"}, "place.map"),
        ({"keepout": "hall.yaml", "cell": 0.5}, "place.keepout"),
    ],
)
def test_a_map_with_the_wrong_negate_is_told_of_negate(folder, place, path):
    """The free cells of a hall become walls, or no-go; the walls around them are too thin for robots."""
    grey = np.full((20, 20), 254, np.uint8)
    grey[[0, -1]] = grey[:, [0, -1]] = 0
    save(grey, "hall.pgm")
    Path("hall.yaml").write_text(HALL.replace("negate: 0", "negate: 1").replace("-1.0, 2.0", "0, 0"))
    text = told(place=place, arena={"side": 10.0, "boundary": "walls"})
    assert text.startswith(f"{path} = '324 closed cells of 400': leaves no cell"), text
    assert "write negate: 0 if the image has dark walls" in text
    assert "place.walls" not in text


IMAGES = {
    "200 million cells": (bomb(20_000, 10_000), "must be at most 4096 x 4096 pixels"),
    "100 million cells": (bomb(12_000, 10_000), "must be at most 4096 x 4096 pixels"),
    "a column too many": (bomb(4097, 1), "must be at most 4096 x 4096 pixels, not 4097 x 1"),
    "too many in a PGM": (b"P5 100000 100000 255\n", "must be at most 4096 x 4096 pixels"),
    "a PNG that ends": (bomb(4000, 4000)[:60], "is damaged: it can't be decoded"),
    "a PNG with little": (bomb(4000, 4000), "is damaged: it can't be decoded"),
    "a PGM that ends": (b"P5 10 10 255\n123", "is damaged: it can't be decoded"),
    "a PGM of words": (b"P2 2 2 255\nno no no no", "is damaged: it can't be decoded"),
    "16 bits": (b"P5 1 1 65535\n\0\0", "must have at most 8 bits per colour"),
    "a GIF": (b"GIF89a" + bytes(50), "must be a PNG or PGM image"),
    "a JPEG": (b"\xff\xd8\xff" + bytes(50), "must be a PNG or PGM image"),
    "nothing": (b"", "must be a PNG or PGM image"),
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


def test_noise_is_no_image(folder):
    assert "must be a PNG in base64" in told(place={"map": {"cell": 0.5, "image": "!"}})
    assert "place.keepout.cell = 0" in told(
        place={"keepout": {"cell": 0, "image": image_of(np.ones((2, 2), bool))}}
    )


SHAPES = {
    "no JSON": ("{", "isn't JSON: Expecting property name"),
    "nested": ("[" * 100_000, "is nested too deeply"),
    "a number": ("5", "must be a Polygon or MultiPolygon, not None"),
    "a point": ('{"type": "Point", "coordinates": [1, 2]}', "must be a Polygon or MultiPolygon, not 'Point'"),
    "a feature of nothing": (
        '{"type": "Feature", "geometry": null}',
        "must be a Polygon or MultiPolygon, not None",
    ),
    "no features": ('{"type": "FeatureCollection"}', "features None must be a list"),
    "empty": ('{"type": "FeatureCollection", "features": []}', "has no polygon"),
    "two points": ('{"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]}', "of 3 or more points"),
    "no rings": ('{"type": "Polygon", "coordinates": []}', "of 3 or more points"),
    "a number for a point": ('{"type": "Polygon", "coordinates": [[1, 2, 3]]}', "point 1.0 must be a list"),
    "words": (
        '{"type": "Polygon", "coordinates": [[["a", 1], [1, 2], [3, 4]]]}',
        "must be a point of two finite",
    ),
    "infinite": (
        '{"type": "Polygon", "coordinates": [[[1e999, 1], [1, 2], [3, 4]]]}',
        "of two finite numbers",
    ),
    "nines": (
        f'{{"type": "Polygon", "coordinates": [[[{"9" * 9000}, 1], [1, 2], [3, 4]]]}}',
        "of two finite",
    ),
    "the second is wrong": (
        '{"type": "FeatureCollection", "features": [{"type": "MultiPolygon", "coordinates": []},'
        ' {"type": "LineString"}]}',
        "feature 2: must be a Polygon or MultiPolygon, not 'LineString'",
    ),
}


@pytest.mark.parametrize("what", SHAPES)
def test_a_wrong_file_of_polygons_is_told(folder, what):
    text, rule = SHAPES[what]
    Path("shape.geojson").write_text(text)
    for place, path in (
        ({"map": "shape.geojson"}, "place.map"),
        ({"keepout": "shape.geojson"}, "place.keepout"),
        ({"zones": {"dock": "shape.geojson"}}, "place.zones.dock"),
    ):
        found = told(place=place)
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


@pytest.mark.parametrize(
    "name", ["pipe.yaml", "pipe.geojson", "loop.yaml", "loop.geojson", "\0.yaml", "x" * 300 + ".yaml"]
)
def test_what_is_no_plain_file_is_not_opened(folder, name):
    os.mkfifo("pipe.yaml"), os.mkfifo("pipe.geojson")
    Path("loop.yaml").symlink_to("loop.yaml")
    Path("loop.geojson").symlink_to("loop.geojson")
    for place in ({"map": name}, {"keepout": name}):
        assert "can't be read" in told(place=place)


PIECES = st.sampled_from(
    [*HALL.splitlines(keepends=True), "a: &a [*a]\n", "- x\n", "\t", "'", "!!x ", "{", "]", "%"]
)


@given(st.lists(st.one_of(PIECES, st.text(max_size=8)), max_size=9).map("".join))
def test_any_yaml_is_read_or_told(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(text, encoding="utf-8", errors="replace")
    read_or_told(path)


@given(
    st.recursive(
        st.one_of(
            st.none(),
            st.floats(),
            st.sampled_from(["Polygon", "Feature", "MultiPolygon", "FeatureCollection"]),
        ),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(
                st.sampled_from(["type", "features", "geometry", "coordinates"]), inner, max_size=3
            )
        ),
        max_leaves=30,
    )
)
def test_any_json_is_read_or_told(tmp_path_factory, value):
    path = tmp_path_factory.getbasetemp() / "any.geojson"
    path.write_text(json.dumps(value))
    read_or_told(path)


@given(
    st.binary(max_size=60),
    st.sampled_from([b"", b"P5 3 3 255\n", b"P2 3 3 255\n", b"\x89PNG\r\n\x1a\n", bomb(3, 3)]),
)
def test_any_image_is_read_or_told(tmp_path_factory, data, start):
    folder = tmp_path_factory.getbasetemp()
    (folder / "hall.pgm").write_bytes(start + data)
    (folder / "image.yaml").write_text(HALL)
    read_or_told(folder / "image.yaml")


def read_or_told(path):
    for key in ("map", "keepout"):
        table, problems = with_plans({key: str(path)}, None, None)
        assert problems or cells_of(table[key]["image"]).size
        assert all(each.path == f"place.{key}" and each.rule and each.remedy for each in problems)


def test_a_file_of_100_megabytes_is_not_read(folder):
    with Path("hall.yaml").open("ab") as file:
        file.truncate(100 * 2**20)
    assert "place.map = 'hall.yaml': can't be read: it is larger than" in told(place={"map": "hall.yaml"})
