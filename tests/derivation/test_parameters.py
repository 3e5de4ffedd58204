"""Vehicle files: what is read from them, what is refused and how, and what may be done with the result."""

import copy
import dataclasses
import errno
import itertools
import math
import pickle
import re
from importlib import resources
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chassym.derivation import quantity
from chassym.derivation.parameters import (
    Parameter,
    Parameters,
    load_parameters,
    parse_assignment,
    parse_parameters,
)
from chassym.derivation.schema import (
    ANY,
    INCREASING,
    NONNEGATIVE,
    POSITIVE,
    ParameterDefinition,
    ParameterError,
    Schema,
)

define = ParameterDefinition
VEHICLES = resources.files("chassym.derivation.vehicles")

CART = Schema(
    "cart",
    (
        define("body.mass", "kg", POSITIVE),
        *(define(f"body.inertia.{axes}", "kg*m^2", POSITIVE) for axes in ("xx", "yy", "zz")),
        define("body.centre", "m", length=3),
        define("damper.velocity", "m/s", INCREASING),
        define("damper.force", "N", same_length_as="damper.velocity"),
        define("damper.lever_ratio", "1", POSITIVE),
        define("damper.temperature", "K", POSITIVE),
        define("spring.stiffness", "N*m/rad", NONNEGATIVE),
    ),
    inertias=("body.inertia",),
)

CART_TEXT = """\
model = "cart"
description = "a cart for tests"
[body]
mass = { value = 475, unit = "kg", description = "mass", source = "weighed" }
centre = { value = [0, -744, 286], unit = "mm", description = "centre", source = "drawing", reading = "left" }
[body.inertia]
xx = { value = 126, unit = "kg*m^2", description = "roll", source = "table" }
yy = { value = 132, unit = "kg*m^2", description = "pitch", source = "table" }
zz = { value = 140, unit = "kg*m^2", description = "yaw", source = "table" }
[damper]
velocity = { value = [-1000, 0, 500], unit = "mm/s", description = "velocities", source = "bench" }
force = { value = [-2400, 0, 1100], unit = "N", description = "forces", source = "bench" }
lever_ratio = { value = 1.43, unit = "1", description = "ratio", source = "drawing" }
temperature = { value = 293, unit = "K", description = "oil", source = "bench" }
[spring]
stiffness = { value = 200, unit = "N*m/deg", description = "torsion bar", source = "bench" }
"""


def full_car_definitions():
    yield define("gravity", "m/s^2", POSITIVE)
    for section in ("front", "middle", "rear"):
        yield define(f"body.{section}.mass", "kg", POSITIVE)
        yield from (
            define(f"body.{section}.inertia.{axes}", "kg*m^2", POSITIVE) for axes in ("xx", "yy", "zz")
        )
        yield from (define(f"body.{section}.mass_centre.{axis}", "m") for axis in "xz")
    for axle in ("front", "rear"):
        suspension = f"suspension.{axle}"
        yield define(f"body.{axle}.torsion_axis.z", "m")
        yield define(f"body.{axle}.torsional_stiffness", "N*m/rad", NONNEGATIVE)
        yield define(f"body.{axle}.stiffness_proportional_damping", "s", NONNEGATIVE)
        yield define(f"axle.{axle}.x", "m")
        points = itertools.product(("arm_pivot", "wheel_centre", "contact_patch"), "yz")
        yield from (define(f"{suspension}.{point}.{axis}", "m") for point, axis in points)
        yield define(f"{suspension}.spring.rate", "N/m", POSITIVE)
        yield define(f"{suspension}.spring.lever_ratio", "1", POSITIVE)
        yield define(f"{suspension}.damper.velocity", "m/s", INCREASING)
        yield define(f"{suspension}.damper.force", "N", same_length_as=f"{suspension}.damper.velocity")
        yield define(f"{suspension}.damper.lever_ratio", "1", POSITIVE)
        yield define(f"{suspension}.anti_roll_bar.rate", "N/m", NONNEGATIVE)
        yield define(f"{suspension}.unsprung.mass", "kg", POSITIVE)
        yield from (
            define(f"{suspension}.unsprung.inertia.{axes}", "kg*m^2", POSITIVE) for axes in ("xx", "yy", "zz")
        )
        yield from (define(f"tyre.{axle}.stiffness.{axis}", "N/m", NONNEGATIVE) for axis in "xyz")
        yield from (define(f"tyre.{axle}.damping.{axis}", "N*s/m", NONNEGATIVE) for axis in "xyz")


FULL_CAR = Schema(
    "full_car",
    tuple(full_car_definitions()),
    (
        *(f"body.{section}.inertia" for section in ("front", "middle", "rear")),
        *(f"suspension.{axle}.unsprung.inertia" for axle in ("front", "rear")),
    ),
)
QUARTER_CAR = Schema(
    "quarter_car",
    (
        define("gravity", "m/s^2", POSITIVE),
        define("sprung.mass", "kg", POSITIVE),
        define("unsprung.mass", "kg", POSITIVE),
        define("spring.rate", "N/m", POSITIVE),
        define("damper.velocity", "m/s", INCREASING),
        define("damper.force", "N", same_length_as="damper.velocity"),
        define("tyre.stiffness", "N/m", POSITIVE),
        define("tyre.damping", "N*s/m", NONNEGATIVE),
    ),
)
HALF_CAR = Schema(
    "half_car",
    (
        define("gravity", "m/s^2", POSITIVE),
        define("body.mass", "kg", POSITIVE),
        define("body.inertia.yy", "kg*m^2", POSITIVE),
        *(define(f"body.mass_centre.{axis}", "m") for axis in "xz"),
        *itertools.chain.from_iterable(
            (
                define(f"axle.{axle}.x", "m"),
                define(f"axle.{axle}.mass", "kg", POSITIVE),
                define(f"suspension.{axle}.spring.rate", "N/m", POSITIVE),
                define(f"suspension.{axle}.damper.coefficient", "N*s/m", NONNEGATIVE),
                define(f"tyre.{axle}.stiffness", "N/m", POSITIVE),
                define(f"tyre.{axle}.damping", "N*s/m", NONNEGATIVE),
            )
            for axle in ("front", "rear")
        ),
    ),
)
TORSION_CHAIN = Schema(
    "torsion_chain",
    (
        *(define(f"inertia.{section}", "kg*m^2", POSITIVE) for section in ("front", "middle", "rear")),
        *(define(f"stiffness.{end}", "N*m/rad", NONNEGATIVE) for end in ("front", "rear")),
        *(define(f"damping.{end}", "N*m*s/rad", NONNEGATIVE) for end in ("front", "rear")),
    ),
)
ALL = (FULL_CAR, QUARTER_CAR, HALF_CAR, TORSION_CHAIN)


@pytest.fixture(scope="module")
def cart() -> Parameters:
    return parse_parameters(CART_TEXT, CART)


@pytest.fixture(scope="module")
def sedan() -> Parameters:
    return load_parameters(VEHICLES / "sedan.toml", FULL_CAR)


def refusal(action, *arguments, **options) -> str:
    """The one line with which something is refused."""
    with pytest.raises(ParameterError) as caught:
        action(*arguments, **options)
    message = str(caught.value)
    assert message.splitlines() == [message]
    return message


def str_id(argument: object) -> str:
    """A short name for a case of a parametrised test."""
    return str(argument)[:30].encode("ascii", "backslashreplace").decode()


# -- reading ---------------------------------------------------------------------------------------------


def test_parameter_carries_si_value_and_provenance(cart):
    expected = Parameter("body.centre", (0.0, -0.744, 0.286), "m", "centre", "drawing", "left")
    found = cart["body.centre"]
    assert found.value == pytest.approx(expected.value, rel=1e-15)
    assert dataclasses.replace(found, value=expected.value) == expected
    assert cart["body.mass"].reading == ""
    assert cart.description == "a cart for tests"
    assert cart.schema is CART


def test_order_is_that_of_the_schema_not_of_the_file(cart):
    header, *tables = re.split(r"(?m)^(?=\[)", CART_TEXT)
    turned = parse_parameters(header + "".join(reversed(tables)), CART)
    assert list(turned) == list(cart) == [definition.name for definition in CART.definitions]
    assert list(turned.flat()) == list(cart.flat())
    assert turned == cart


def test_flat_expands_lists_in_place(cart):
    assert list(cart.flat().items())[4:11] == [
        ("body.centre[0]", 0.0),
        ("body.centre[1]", -0.744),
        ("body.centre[2]", pytest.approx(0.286)),
        ("damper.velocity[0]", -1.0),
        ("damper.velocity[1]", 0.0),
        ("damper.velocity[2]", 0.5),
        ("damper.force[0]", -2400.0),
    ]
    assert all(type(number) is float for number in cart.flat().values())


def test_leaf_may_be_a_table_of_its_own(cart):
    line = re.search(r"(?m)^mass = \{ (.*) \}\n", CART_TEXT)
    own_table = "[body.mass]\n" + "\n".join(line[1].split(", ")) + "\n"
    assert parse_parameters(CART_TEXT.replace(line[0], "") + own_table, CART) == cart


def test_file_and_text_read_the_same(tmp_path, cart):
    file = tmp_path / "cart.toml"
    file.write_text(CART_TEXT, encoding="utf-8")
    assert load_parameters(file, CART) == load_parameters(str(file), CART) == cart


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_model_of_the_file_chooses_among_schemas(order, cart):
    offered = [(CART, QUARTER_CAR)[index] for index in order]
    assert parse_parameters(CART_TEXT, *offered).schema is CART


# -- units -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("body.mass", "0.5 t", 500.0),
        ("body.mass", "1 lb", 0.45359237),
        ("body.mass", "475e3g", 475.0),
        ("body.inertia.xx", "1.3e6 kg*cm**2", 130.0),
        ("body.inertia.xx", "130 kg m^2", 130.0),
        ("damper.lever_ratio", "143 %", 1.43),
        ("damper.lever_ratio", "1.43", 1.43),
        ("damper.temperature", "20 degC", 293.15),
        ("damper.temperature", "212 degF", 373.15),
        ("damper.force", "[-1, +.5, 1.] kN", (-1000.0, 500.0, 1000.0)),
        ("damper.force", "[-1, 0, 1] lbf", (-4.4482216152605, 0.0, 4.4482216152605)),
        ("damper.velocity", "[-3.6, 0, 36] km/h", (-1.0, 0.0, 10.0)),
        ("damper.velocity", "[-1000, 0, 1] mm*s^-1", (-1.0, 0.0, 0.001)),
        ("body.centre", "[1, 2, 3] in", (0.0254, 0.0508, 0.0762)),
        ("spring.stiffness", "200 N*m/deg", 200 * 180 / math.pi),
        ("spring.stiffness", "5000e6 N*mm/rad", 5e6),
        ("spring.stiffness", "0", 0.0),
    ],
)
def test_text_with_a_unit_becomes_si(cart, name, text, expected):
    assert cart.replace({name: text}).value(name) == pytest.approx(expected, rel=1e-12)


def test_unit_of_a_file_becomes_si(cart):
    assert cart.value("spring.stiffness") == pytest.approx(200 * 180 / math.pi, rel=1e-15)
    assert cart["spring.stiffness"].unit == "N*m/rad"


def test_values_in_si_do_not_need_pint(monkeypatch, cart):
    def no_registry():
        raise AssertionError("pint was asked")

    monkeypatch.setattr(quantity, "_unit_registry", no_registry)
    text = CART_TEXT.replace('"mm"', '"m"').replace('"mm/s"', '"m/s"').replace('"N*m/deg"', '"N*m/rad"')
    assert parse_parameters(text, CART).value("spring.stiffness") == 200.0
    assert cart.replace({"body.mass": 3, "damper.force": "[1, 2, 3] N"}).value("body.mass") == 3.0


@given(st.floats(min_value=1e-300, max_value=1e300))
def test_text_in_si_is_exact(mass):
    assert parse_parameters(CART_TEXT, CART).replace({"body.mass": repr(mass)}).value("body.mass") == mass


@given(
    st.floats(min_value=-1e12, max_value=1e12), st.sampled_from([("km", 1e3), ("mm", 1e-3), ("ft", 0.3048)])
)
def test_conversion_is_linear(number, unit):
    name, factor = unit
    converted = parse_parameters(CART_TEXT, CART).replace({"body.centre": f"[{number!r}, 0, 1] {name}"})
    assert converted.value("body.centre") == pytest.approx(
        (factor * number, 0, factor), rel=1e-14, abs=1e-300
    )


# -- refusals --------------------------------------------------------------------------------------------

REFUSED_VALUES = [
    # parameter, value and unit in the file; what the message says was received and is accepted
    ("body.mass", '"475"', "kg", "'475' kg", "one finite number"),
    ("body.mass", "true", "kg", "True kg", "one finite number"),
    ("body.mass", "2026-01-01", "kg", "2026, 1, 1", "one finite number"),
    ("body.mass", "[475]", "kg", "[475] kg", "one finite number"),
    ("body.mass", "nan", "kg", "nan kg", "finite"),
    ("body.mass", "-inf", "kg", "-inf kg", "finite"),
    ("body.mass", "1e400", "kg", "inf kg", "finite"),
    ("body.mass", "1" + 400 * "0", "kg", "10000000", "finite"),
    ("body.mass", "0x1" + 5000 * "0", "kg", "too long to print", "finite"),
    ("body.mass", "1e308", "t", "1e+308 t", "finite"),
    ("body.mass", "0", "kg", "0 kg", "greater than zero"),
    ("body.mass", "-475e3", "g", "-475000.0 g", "greater than zero"),
    ("body.mass", "475", "mm", "'mm' of dimension [length]", "same dimension as kg"),
    ("body.mass", "475", "degC", "'degC' of dimension [temperature]", "same dimension as kg"),
    ("body.inertia.zz", "140", "kg*m", "'kg*m' of dimension [", "same dimension as kg*m^2"),
    ("body.centre", "286", "mm", "286 mm", "a list of 3 finite numbers"),
    ("body.centre", '"286"', "mm", "'286' mm", "a list of 3 finite numbers"),
    ("body.centre", "[0, 286]", "mm", "[0, 286] mm", "a list of 3 finite numbers"),
    ("body.centre", "[]", "mm", "[] mm", "a list of 3 finite numbers"),
    ("body.centre", "[0, true, 286]", "mm", "[0, True, 286] mm", "a list of 3 finite numbers"),
    ("body.centre", "[[0, 1], 2, 3]", "mm", "[[0, 1], 2, 3] mm", "a list of 3 finite numbers"),
    ("body.centre", "[nan, 0, 0]", "mm", "[nan, 0, 0] mm", "finite"),
    ("body.centre", "[0, 0, 0]", "degF", "'degF' of dimension [temperature]", "as m"),
    ("damper.velocity", "[-1, 0, 0]", "mm/s", "[-1, 0, 0] mm/s", "strictly increasing"),
    ("damper.velocity", "[1, 0, -1]", "mm/s", "[1, 0, -1] mm/s", "strictly increasing"),
    ("damper.velocity", "[0]", "mm/s", "[0] mm/s", "at least 2"),
    ("damper.velocity", "3", "mm/s", "3 mm/s", "at least 2"),
    ("damper.force", "[-2400, 0]", "N", "2 values", "damper.velocity has: 3"),
    ("damper.lever_ratio", "1.43", "mm", "'mm' of dimension [length]", "same dimension as 1"),
    ("damper.temperature", "-300", "degC", "-300 degC", "greater than zero"),
    ("spring.stiffness", "-1e-9", "N*m/deg", "-1e-09 N*m/deg", "zero or greater"),
]
UNKNOWN_UNITS = [
    "furlongg",
    "10 mm",
    "2*kg",
    "'kg'",
    "²",
    "kg=1",
    "kg+kg",
    "kg/0",
    "kg kg(",
    "((",
    "m**",
    "N/",
]
ENDLESS_UNITS = ["kg**9**9**9**9", "9**9**9**9 kg", "kg^(9^9^9)", "kg**9 **999999999999", "kg" + 5000 * "*kg"]
REFUSED_EDITS = [
    # pattern in the file and what replaces it; key, what the message says was received and is accepted
    (r"\[spring\]", "[spring", "file", "at line 15", "TOML"),
    ("value = 475", f"value = 1{5000 * '0'}", "file", "4300 digits", "TOML"),
    ("model = .*", "", "model", "nothing", "one of cart"),
    ("model = .*", 'model = "horse"', "model", "'horse'", "one of cart"),
    ("model = .*", "model = 3", "model", "3", "one of cart"),
    ("description = .*", "", "description", "nothing", "text"),
    ("description = .*", "description = 3", "description", "3", "text"),
    ("mass = .*", "", "body.mass", "nothing", "{ value, unit, description, source }: one finite number"),
    ("mass = .*", "mass = 475", "body.mass", "475", "{ value, unit, description, source }: one finite"),
    (r"\[body.inertia\]\n(.*\n){3}", "", "body.inertia.xx", "nothing", "one finite number"),
    ("lever_ratio =", "lever_ratoi =", "damper.lever_ratoi", "an unknown name", "damper.lever_ratio"),
    (r"\[damper\]", "[dampers]", "dampers", "an unknown name", "damper"),
    (r"\[body\]", "author = 'me'\n[body]", "author", "an unknown name", "one such as"),
    (r"\[body\]", '"body.mass" = 3\n[body]', '"body.mass"', "an unknown name", "body.mass"),
    (r"\[body\]", r'"a\\nb" = 3' + "\n[body]", "a b", "an unknown name", "one such as"),
    (r"\[body\]", "[body]\ndamping = {}", "body.damping", "an unknown name", "one such as"),
    (
        r"(?s)\[body\](.*)\[spring\].*",
        r"spring = 7\n[body]\1",
        "spring",
        "7",
        "a table of parameters spring.*",
    ),
    ('"kg"', '"kg", colour = "red"', "body.mass.colour", "an unknown field", "one of value, unit"),
    ("value = 475, ", "", "body.mass.value", "nothing", "one finite number"),
    ('unit = "kg", ', "", "body.mass.unit", "nothing", "text"),
    ('unit = "kg"', 'unit = " "', "body.mass.unit", "' '", "text"),
    ('unit = "kg"', r'unit = "kg\\nx9"', "body.mass", r"the unit 'kg\nx9'", "same dimension as kg"),
    ('unit = "kg"', "unit = 1", "body.mass.unit", "1", "text"),
    ('description = "mass", ', "", "body.mass.description", "nothing", "text"),
    (', source = "weighed"', "", "body.mass.source", "nothing", "text"),
    ('"weighed"', '""', "body.mass.source", "''", "text"),
    ('"left"', "true", "body.centre.reading", "True", "text"),
    ("value = 140", "value = 258.1", "body.inertia", "zz = 258.1", "at most the sum of the other two"),
]


def assert_says(message: str, origin: str, key: str, received: str, accepted: str) -> None:
    start = f"{origin}: {key}: received "
    assert message.startswith(start)
    got, expected = message.removeprefix(start).split(", expected ", 1)
    assert received in got
    assert accepted in expected
    assert len(got) < 250


def refused_edit(folder, pattern: str, replacement: str) -> tuple[str, str]:
    """The cart's file after an edit, and the message that refuses it."""
    text = re.sub(pattern, replacement, CART_TEXT, count=1)
    assert text != CART_TEXT
    file = folder / "broken.toml"
    file.write_text(text, encoding="utf-8")
    return str(file), refusal(load_parameters, file, CART)


def refused_leaf(folder, name: str, value: str, unit: str) -> tuple[str, str]:
    """The cart's file with another value and unit, and the message that refuses it."""
    leaf = rf"(?m)^({name.rpartition('.')[2]} = )\{{ value = .*?, unit = .*?,"
    return refused_edit(folder, leaf, rf'\1{{ value = {value}, unit = "{unit}",')


@pytest.mark.parametrize(("name", "value", "unit", "received", "accepted"), REFUSED_VALUES, ids=str_id)
def test_value_in_a_file_is_refused(tmp_path, name, value, unit, received, accepted):
    file, message = refused_leaf(tmp_path, name, value, unit)
    assert_says(message, file, name, received, accepted)


@pytest.mark.parametrize("unit", [*UNKNOWN_UNITS, *ENDLESS_UNITS], ids=str_id)
def test_unit_in_a_file_is_refused(tmp_path, unit):
    file, message = refused_leaf(tmp_path, "body.mass", "475", unit)
    assert_says(message, file, "body.mass", f"the unit {unit[:10]!r}"[:-1], "one of the same dimension as kg")


@pytest.mark.parametrize(("pattern", "replacement", "key", "received", "accepted"), REFUSED_EDITS, ids=str_id)
def test_file_is_refused(tmp_path, pattern, replacement, key, received, accepted):
    file, message = refused_edit(tmp_path, pattern, replacement)
    assert_says(message, file, key, received, accepted)


def test_missing_file_is_refused(tmp_path):
    file = tmp_path / "none.toml"
    message = refusal(load_parameters, file, CART)
    assert_says(message, str(file), "file", "No such file or directory", "a readable TOML file")


def test_folder_is_refused(tmp_path):
    assert_says(
        refusal(load_parameters, tmp_path, CART), str(tmp_path), "file", "error (", "readable TOML file"
    )


def test_unreadable_file_is_refused(tmp_path, monkeypatch):
    def closed(*_arguments, **_options):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "read_text", closed)  # the superuser may read every real file
    message = refusal(load_parameters, tmp_path / "closed.toml", CART)
    assert_says(message, str(tmp_path / "closed.toml"), "file", "Permission denied", "a readable TOML file")


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"model = \x00", b"\x89PNG\r\n"])
def test_file_that_is_not_text_is_refused(tmp_path, content):
    file = tmp_path / "picture.toml"
    file.write_bytes(content)
    assert refusal(load_parameters, file, CART).startswith(f"{file}: file: received ")


def test_path_with_a_null_character_is_refused():
    assert "null" in refusal(load_parameters, "a\0b", CART)


def test_name_of_a_file_with_a_line_break_stays_on_one_line(tmp_path):
    assert "a b.toml" in refusal(load_parameters, tmp_path / "a\nb.toml", CART)


@pytest.mark.parametrize(
    "text", ["a = " + 5000 * "[", "body" + 5000 * ".a" + " = 1", "[body" + 5000 * ".a" + "]"]
)
def test_deep_nesting_is_refused(text):
    assert refusal(parse_parameters, 'model = "cart"\ndescription = "deep"\n' + text, CART).startswith(
        "text: "
    )


def test_flat_plate_is_the_limit_of_the_triangle_inequality(cart):
    plate = {"body.inertia.xx": 0.1, "body.inertia.yy": 4.1, "body.inertia.zz": 4.2}
    assert 2 * 4.2 > 0.1 + 4.1 + 4.2, "rounding alone must not refuse a plate"
    assert cart.replace(plate).value("body.inertia.zz") == 4.2
    assert "body.inertia" in refusal(cart.replace, plate | {"body.inertia.zz": 4.2 * (1 + 1e-9)})


# -- replacing and scaling -------------------------------------------------------------------------------


def test_replace_leaves_the_original_and_the_rest(cart):
    before = copy.deepcopy(cart)
    heavier = cart.replace({"body.mass": 500})
    assert heavier.value("body.mass") == 500.0
    assert {name for name in cart if heavier[name] != cart[name]} == {"body.mass"}
    assert list(heavier) == list(cart)
    assert cart == before


def test_replaced_value_names_its_origin(cart):
    changed = cart.replace({"body.centre": [1, 2, 3]}, origin="--set")["body.centre"]
    assert (changed.source, changed.reading) == ("--set", "")
    assert (changed.description, changed.unit) == ("centre", "m")


def test_replacing_every_value_by_itself_changes_no_number(sedan):
    assert sedan.replace({name: sedan.value(name) for name in sedan}).flat() == sedan.flat()


def test_a_table_is_replaced_as_a_whole(cart):
    longer = cart.replace({"damper.velocity": [-1, -0.5, 0, 1], "damper.force": "[-4, -2, 0, 1] kN"})
    assert longer.value("damper.force") == (-4000.0, -2000.0, 0.0, 1000.0)
    assert len(longer.flat()) == len(cart.flat()) + 2


REFUSED_CHANGES = [
    ("body.mas", 3, "body.mas", "an unknown name", "body.mass"),
    ("body", 3, "body", "an unknown name", "one such as body"),
    ("?", 3, "?", "an unknown name", "one such as"),
    ("body.mass", "heavy", "body.mass", "'heavy'", "200 N*m/deg"),
    ("body.mass", "", "body.mass", "''", "200 N*m/deg"),
    ("body.mass", "0x10", "body.mass", "the unit 'x10'", "same dimension as kg"),
    ("body.mass", "3 mm", "body.mass", "'mm' of dimension [length]", "same dimension as kg"),
    ("body.mass", "3 stones_", "body.mass", "the unit 'stones_'", "same dimension as kg"),
    ("body.mass", "inf kg", "body.mass", "inf kg", "finite"),
    ("body.mass", "1e400", "body.mass", "inf kg", "finite"),
    ("body.mass", "-1 t", "body.mass", "-1.0 t", "greater than zero"),
    ("body.mass", "[1, 2] kg", "body.mass", "[1.0, 2.0] kg", "one finite number"),
    ("body.mass", math.nan, "body.mass", "nan kg", "finite"),
    ("body.mass", True, "body.mass", "True kg", "one finite number"),
    ("body.mass", None, "body.mass", "None kg", "one finite number"),
    ("body.centre", "[1, 2, 3", "body.centre", "'[1, 2, 3'", "[-1, 0, 1] m/s"),
    ("body.centre", "[1, two, 3] m", "body.centre", "'[1, two, 3] m'", "[-1, 0, 1] m/s"),
    ("body.centre", "[1,, 3] m", "body.centre", "'[1,, 3] m'", "[-1, 0, 1] m/s"),
    ("body.centre", "1 m", "body.centre", "1.0 m", "a list of 3 finite numbers"),
    ("damper.velocity", [3, 2, 1], "damper.velocity", "[3, 2, 1] m/s", "strictly increasing"),
    ("damper.velocity", [1, 2], "damper.force", "3 values", "damper.velocity has: 2"),
    ("body.inertia.xx", 5, "body.inertia", "xx = 5, yy = 132", "at most the sum of the other two"),
]


@pytest.mark.parametrize(("name", "given_value", "key", "received", "accepted"), REFUSED_CHANGES)
def test_change_is_refused(cart, name, given_value, key, received, accepted):
    assert_says(refusal(cart.replace, {name: given_value}), "override", key, received, accepted)
    assert_says(refusal(cart.replace, {name: given_value}, origin="--set"), "--set", key, received, accepted)


def test_endless_whole_number_is_refused(cart):
    message = refusal(cart.replace, {"body.mass": 10**5000})
    assert_says(message, "override", "body.mass", "a value too long to print kg", "finite")


@given(st.floats(min_value=1e-3, max_value=1e3))
def test_scaled_multiplies_what_lies_below_a_prefix(factor):
    cart = parse_parameters(CART_TEXT, CART)
    scaled = cart.scaled("body.inertia", "damper.force", factor=factor)
    touched = ("body.inertia.", "damper.force[")
    for name, number in scaled.flat().items():
        assert number == (factor * cart.flat()[name] if name.startswith(touched) else cart.flat()[name])


def test_scaled_multiplies_once_however_often_named(cart):
    twice = cart.scaled("body", "body.inertia", "body.mass", "body.mass", factor=2)
    assert twice.value("body.mass") == 2 * cart.value("body.mass")
    assert twice.value("body.inertia.zz") == 2 * cart.value("body.inertia.zz")
    assert twice["body.mass"].source == "scaled by 2"


def test_prefix_ends_at_a_dot(sedan):
    lighter = sedan.scaled("body.front.mass", factor=0.5)
    assert [name for name in sedan if sedan[name] != lighter[name]] == ["body.front.mass"]


@pytest.mark.parametrize(
    ("name", "factor", "key", "accepted"),
    [
        ("body.mas", 2, "body.mas", "body.mass"),
        ("body.m", 2, "body.m", "body.mass"),
        ("", 2, "", "one such as"),
        ("body.mass", 0, "body.mass", "greater than zero"),
        ("body.mass", math.nan, "body.mass", "finite"),
        ("damper.velocity", -1, "damper.velocity", "strictly increasing"),
        ("body.inertia.zz", 10, "body.inertia", "sum of the other two"),
    ],
)
def test_scaling_is_refused(cart, name, factor, key, accepted):
    message = refusal(cart.scaled, name, factor=factor)
    assert message.startswith(f"scaled by {factor}: {key}: received ")
    assert accepted in message


def test_value_of_an_unknown_name_is_refused(cart):
    assert "body.mas: received an unknown name, expected one such as body.mass" in refusal(
        cart.value, "body.mas"
    )


# -- value semantics -------------------------------------------------------------------------------------


def test_parameters_are_a_mapping_of_parameters(cart):
    assert "body.mass" in cart
    assert "body" not in cart
    assert cart.get("body") is None
    with pytest.raises(KeyError):
        cart["body"]
    assert len(cart) == len(CART.definitions)
    assert all(
        isinstance(parameter, Parameter) and parameter.name == name for name, parameter in cart.items()
    )


def test_parameters_are_immutable(cart):
    with pytest.raises(TypeError):
        cart["body.mass"] = cart["body.mass"]
    with pytest.raises(TypeError):
        del cart["body.mass"]
    with pytest.raises(dataclasses.FrozenInstanceError):
        cart.description = "other"
    with pytest.raises(dataclasses.FrozenInstanceError):
        cart["body.mass"].value = 3.0
    cart.flat()["body.mass"] = 3.0
    assert cart.flat()["body.mass"] == 475.0


def test_parameters_survive_pickling_with_their_checks(cart):
    travelled = pickle.loads(pickle.dumps(cart))
    assert travelled == cart
    assert hash(travelled) == hash(cart)
    assert "increasing" in refusal(travelled.replace, {"damper.velocity": [1, 1, 1]})
    assert "greater than zero" in refusal(travelled.replace, {"body.mass": -1})


def test_equal_sets_are_equal_and_others_are_not(cart):
    assert cart == parse_parameters(CART_TEXT, CART)
    assert cart != cart.replace({"body.mass": 476})
    assert len({cart, parse_parameters(CART_TEXT, CART), cart.replace({"body.mass": 476})}) == 2


def test_short_representation(sedan):
    assert (
        repr(sedan)
        == "<Parameters of full_car: reference sedan of Liu 2016, with a body flexible in torsion>"
    )


def test_definitions_say_what_they_expect():
    assert define("a", "m").expected == "one finite number, in m"
    assert define("a", "m", ANY, length=3).expected == "a list of 3 finite numbers, in m"
    assert (
        define("a", "1", POSITIVE).expected
        == "one finite number, greater than zero, in unit 1 (dimensionless)"
    )
    expected = "a list of at least 2 finite numbers, strictly increasing, in m/s"
    assert define("a", "m/s", INCREASING).expected == expected


# -- the command line's --set ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("body.mass=480 kg", ("body.mass", "480 kg")),
        (" body.mass = 480 ", ("body.mass", "480")),
        ("damper.force=[-1, 0, 1] kN", ("damper.force", "[-1, 0, 1] kN")),
        ("body.mass=1=2", ("body.mass", "1=2")),
    ],
)
def test_assignment(text, expected):
    assert parse_assignment(text) == expected


@pytest.mark.parametrize("text", ["", "body.mass", "=3", "body.mass=", " = ", "body.mass 3"])
def test_assignment_is_refused(text):
    message = refusal(parse_assignment, text)
    assert message.startswith(f"--set: received {text!r}, expected NAME=VALUE")


# -- the built-in vehicles -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "schema"),
    [
        ("sedan", FULL_CAR),
        ("quarter_car", QUARTER_CAR),
        ("half_car", HALF_CAR),
        ("torsion_chain", TORSION_CHAIN),
    ],
)
def test_built_in_vehicle_is_complete(file, schema):
    vehicle = load_parameters(VEHICLES / f"{file}.toml", *ALL)
    assert vehicle.schema is schema
    assert all("Liu 2016" in parameter.source for name, parameter in vehicle.items() if name != "gravity")


def test_sedan_is_table_1_of_the_thesis(sedan):
    expected = {
        "gravity": 9.81,
        **{f"body.{section}.mass": 475.0 for section in ("front", "middle", "rear")},
        **{f"body.{section}.inertia.xx": 126.0 for section in ("front", "middle", "rear")},
        **{
            f"body.{section}.inertia.{axes}": 132.0
            for section in ("front", "middle", "rear")
            for axes in ("yy", "zz")
        },
        **{f"body.{section}.mass_centre.z": 0.286 for section in ("front", "middle", "rear")},
        "body.front.mass_centre.x": 0.0,
        "body.middle.mass_centre.x": 1.184,
        "body.rear.mass_centre.x": 2.766,
    }
    columns = {
        "body.{}.torsion_axis.z": (0.286, 0.286),
        "body.{}.torsional_stiffness": (5e6, 5e6),
        "body.{}.stiffness_proportional_damping": (1e-3, 1e-3),
        "axle.{}.x": (0.0, 2.766),
        "suspension.{}.arm_pivot.y": (1.364, 0.577),
        "suspension.{}.arm_pivot.z": (0.1927, 0.0403),
        "suspension.{}.wheel_centre.y": (-0.744, -0.744),
        "suspension.{}.wheel_centre.z": (0.0, 0.0),
        "suspension.{}.contact_patch.y": (-0.744, -0.744),
        "suspension.{}.contact_patch.z": (-0.313, -0.313),
        "suspension.{}.spring.rate": (32e3, 61e3),
        "suspension.{}.spring.lever_ratio": (1.43, 1.91),
        "suspension.{}.damper.velocity": ((-1.0, -0.15, 0.0, 0.1, 1.0), (-1.0, -0.15, 0.0, 0.1, 1.0)),
        "suspension.{}.damper.force": (
            (-2400.0, -1200.0, 0.0, 200.0, 1100.0),
            (-1100.0, -488.0, 0.0, 125.0, 350.0),
        ),
        "suspension.{}.damper.lever_ratio": (1.43, 1.30),
        "suspension.{}.anti_roll_bar.rate": (5.51e3, 3.36e3),
        "suspension.{}.unsprung.mass": (48.0, 45.0),
        "suspension.{}.unsprung.inertia.xx": (1.34, 1.26),
        "suspension.{}.unsprung.inertia.yy": (2.35, 2.20),
        "suspension.{}.unsprung.inertia.zz": (1.34, 1.26),
        "tyre.{}.stiffness.x": (273e3, 273e3),
        "tyre.{}.stiffness.y": (113e3, 113e3),
        "tyre.{}.stiffness.z": (150e3, 150e3),
        "tyre.{}.damping.x": (270.0, 270.0),
        "tyre.{}.damping.y": (110.0, 110.0),
        "tyre.{}.damping.z": (150.0, 150.0),
    }
    for name, pair in columns.items():
        expected |= {name.format(axle): value for axle, value in zip(("front", "rear"), pair, strict=True)}
    assert {name: sedan.value(name) for name in sedan} == {
        name: pytest.approx(value, rel=1e-14) for name, value in expected.items()
    }


def test_thesis_spring_rate_at_the_wheel(sedan):
    rate = (
        sedan.value("suspension.front.spring.rate") / sedan.value("suspension.front.spring.lever_ratio") ** 2
    )
    assert rate == pytest.approx(15.6e3, abs=50)


def slopes_at_rest(vehicle: Parameters, axle: str) -> tuple[float, float]:
    """Slope of an axle's damper table at the wheel just below and just above zero velocity."""
    place = f"suspension.{axle}.damper"
    velocity, force = (vehicle.value(f"{place}.{column}") for column in ("velocity", "force"))
    at_rest, ratio = velocity.index(0.0), vehicle.value(f"{place}.lever_ratio")
    below, above = (
        (force[first + 1] - force[first]) / (velocity[first + 1] - velocity[first])
        for first in (at_rest - 1, at_rest)
    )
    return below / ratio**2, above / ratio**2


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_rebound_is_the_stiffer_side_of_the_damper(sedan, axle):
    rebound, jounce = slopes_at_rest(sedan, axle)
    assert rebound > jounce


def test_quarter_car_is_the_front_corner_of_the_sedan(sedan):
    corner = load_parameters(VEHICLES / "quarter_car.toml", QUARTER_CAR)
    sections = sum(sedan.value(f"body.{section}.mass") for section in ("front", "middle", "rear"))
    assert corner.value("sprung.mass") == sections / 4
    assert corner.value("unsprung.mass") == sedan.value("suspension.front.unsprung.mass")
    assert corner.value("spring.rate") == pytest.approx(32e3 / 1.43**2, rel=5e-5)
    assert corner.value("damper.velocity") == sedan.value("suspension.front.damper.velocity")
    forces = [force / 1.43**2 for force in sedan.value("suspension.front.damper.force")]
    assert corner.value("damper.force") == pytest.approx(forces, abs=5e-4)
    assert corner.value("tyre.stiffness") == sedan.value("tyre.front.stiffness.z")
    assert corner.value("tyre.damping") == sedan.value("tyre.front.damping.z")


def test_half_car_is_half_of_the_sedan(sedan):
    half = load_parameters(VEHICLES / "half_car.toml", HALF_CAR)
    sections = ("front", "middle", "rear")
    masses = [sedan.value(f"body.{section}.mass") for section in sections]
    places = [sedan.value(f"body.{section}.mass_centre.x") for section in sections]
    centre = sum(mass * x for mass, x in zip(masses, places, strict=True)) / sum(masses)
    own = sum(sedan.value(f"body.{section}.inertia.yy") for section in sections)
    about_centre = own + sum(mass * (x - centre) ** 2 for mass, x in zip(masses, places, strict=True))
    assert half.value("body.mass") == sum(masses) / 2
    assert half.value("body.mass_centre.x") == pytest.approx(centre, abs=5e-5)
    assert half.value("body.inertia.yy") == pytest.approx(about_centre / 2, abs=0.05)
    assert half.value("body.mass_centre.z") == sedan.value("body.middle.mass_centre.z")


@pytest.mark.parametrize(("axle", "rate"), [("front", 32e3 / 1.43**2), ("rear", 61e3 / 1.91**2)])
def test_axle_of_the_half_car_is_one_side_of_the_sedan(sedan, axle, rate):
    half = load_parameters(VEHICLES / "half_car.toml", HALF_CAR)
    assert half.value(f"axle.{axle}.x") == sedan.value(f"axle.{axle}.x")
    assert half.value(f"axle.{axle}.mass") == sedan.value(f"suspension.{axle}.unsprung.mass")
    assert half.value(f"suspension.{axle}.spring.rate") == pytest.approx(rate, rel=5e-5)
    coefficient = sum(slopes_at_rest(sedan, axle)) / 2
    assert half.value(f"suspension.{axle}.damper.coefficient") == pytest.approx(coefficient, abs=0.5)
    assert half.value(f"tyre.{axle}.stiffness") == sedan.value(f"tyre.{axle}.stiffness.z")
    assert half.value(f"tyre.{axle}.damping") == sedan.value(f"tyre.{axle}.damping.z")


def test_torsion_chain_is_the_body_of_the_sedan(sedan):
    chain = load_parameters(VEHICLES / "torsion_chain.toml", TORSION_CHAIN)
    for section in ("front", "middle", "rear"):
        assert chain.value(f"inertia.{section}") == sedan.value(f"body.{section}.inertia.xx")
    for end in ("front", "rear"):
        stiffness = sedan.value(f"body.{end}.torsional_stiffness")
        assert chain.value(f"stiffness.{end}") == stiffness
        damping = stiffness * sedan.value(f"body.{end}.stiffness_proportional_damping")
        assert chain.value(f"damping.{end}") == pytest.approx(damping)


def test_first_torsional_mode_lies_where_the_thesis_puts_it():
    """Three equal inertias on two equal springs: in the first elastic mode the ends oppose, w^2 = k/I."""
    chain = load_parameters(VEHICLES / "torsion_chain.toml", TORSION_CHAIN)
    frequency_hz = math.sqrt(chain.value("stiffness.front") / chain.value("inertia.front")) / (2 * math.pi)
    assert 30 <= frequency_hz <= 40
    assert "31.7 Hz" in chain["stiffness.front"].reading
    assert frequency_hz == pytest.approx(31.7, abs=0.05)
