"""Designs side by side: their numbers are those of the Python interface, and the page keeps, restores and removes them."""

import copy
import functools

import pytest

import infinivar as iv
from explorer_pages import SIZES, Page
from internals import RefusedError, performance
from internals import answered_request as answered
from internals import document_answer as document
from sampled import sampled

MINUTES = 30.0


def opened(name):
    document.begin()
    found = answered("shipped", {"which": name}).header
    return {"name": name, "tables": copy.deepcopy(found["tables"])}


def rows(asked, **more):
    found = answered("design", {**asked, "time": 60.0 * MINUTES, **more}).header
    return found, {row["key"]: row for row in found["rows"]}


@sampled("name", ["knee_walking", "reach_and_hold", "ankle_walking", "hand_controller"], slow=2)
def test_a_drive_has_the_numbers_of_compare(name):
    asked = opened(name)
    study = iv.Study.from_dict(asked["tables"], name=name)
    compared = iv.compare(study, quick=True)
    for drive, made in study.drives.items():
        found, row = rows(asked, drive=drive, speed=0.1, force=15.0)
        assert found["able"] == compared.able(drive)
        assert row["mass"]["value"] == pytest.approx(compared.masses[drive].known, rel=1e-12)
        assert row["mass"]["lacks"] == ", ".join(compared.masses[drive].open)
        for key, cycle in compared.duty.items():
            own = cycle.results[drive]
            assert row[f"duty.{key}"]["value"] == pytest.approx(own.power_in, rel=1e-12)
            hottest = max(own.windings_after(60.0 * MINUTES).values())
            assert row[f"heat.{key}"]["value"] == pytest.approx(hottest, rel=1e-12)
            settled = max(hot.winding for hot in own.heat.values())
            assert hottest <= settled * (1 + 1e-12)
        if study.requirement is not None:
            assert row["region"]["value"] == pytest.approx(compared.results[drive].mean_loss, rel=1e-12)
        margins = [own.results[drive].tightest[1] for own in compared.duty.values()]
        if compared.results[drive].tightest is not None:
            margins.append(compared.results[drive].tightest.value)
        assert row["margin"]["value"] == pytest.approx(min(margins), rel=1e-12)
        assert row["margin"]["beyond"] == (min(margins) < 1.0)
        point = made.operate(speed=0.1, force=15.0)
        assert row["point"]["value"] == pytest.approx(float(point.power_in), rel=1e-12)
        motor = performance.motors_of(made)["motor"]
        friction = sum(float(point.losses[one]) for one in ("motor friction", "motor iron") if one in point.losses)
        held = iv.parts.heat.heat(motor, float(point.states["motor_current_A"]), friction, 60.0 * MINUTES)
        assert row["point.heat"]["value"] == pytest.approx(held.winding_history[1], rel=1e-9)


@sampled("name", ["six_leg_display", "planar_cart", "two_joint_arm"], slow=2)
def test_a_machine_has_the_numbers_of_compare(name):
    asked = opened(name)
    compared = iv.compare(iv.Study.from_dict(asked["tables"], name=name), quick=True)
    for drive, own in compared.results.items():
        found, row = rows(asked, drive=drive)
        assert found["able"] == own.feasible
        for key, one in own.found.items():
            assert row[key]["value"] == pytest.approx(one.mean_power, rel=1e-12)
        assert row["margin"]["value"] == pytest.approx(min(one.margin for one in own.found.values()), rel=1e-12)


def test_a_study_of_sessions_has_no_rows_and_a_wrong_time_is_refused():
    assert rows(opened("guided_cart"), drive="cart")[0]["rows"] == []
    for time in (0.0, -1.0, float("nan"), 1e300, "30", None, True):
        with pytest.raises(RefusedError, match="time"):
            answered("design", {**opened("knee_walking"), "drive": "cobotic", "time": time})


@sampled("name", ["knee_walking", "reach_and_hold", "two_joint_arm"], slow=2)
def test_a_part_tried_has_the_numbers_of_compare(name):
    """As the drive of the study that has it: the power that decides, and the least margin."""
    asked = opened(name)
    drive = next(iter(asked["tables"]["drives"]))
    fields = answered("study", asked).header["fields"]
    at = next(
        one["at"] for one in fields if one["owner"] == drive and one["type"] == "part" and one["part_kind"] == "motors"
    )
    found = answered("tried", {**asked, "drive": drive, "at": at, "parts": ["", "re-40-24v", "no-such-motor"]}).header[
        "rows"
    ]
    changed = copy.deepcopy(asked["tables"])
    functools.reduce(lambda inside, key: inside.setdefault(key, {}), at[:-1], changed)[at[-1]] = "re-40-24v"
    for row, tables in zip(found, (asked["tables"], changed), strict=False):
        compared = iv.compare(iv.Study.from_dict(tables, name=name), quick=True)
        own = compared.results[drive]
        if isinstance(compared, iv.Comparison):
            cycles = [cycle.results[drive] for cycle in compared.duty.values()]
            margins = [one.tightest[1] for one in cycles] + ([own.tightest.value] if own.tightest else [])
            power = sum(one.power_in for one in cycles) / len(cycles)
        else:
            margins = [one.margin for one in own.found.values()]
            power = own.mean_power if own.shares else sum(one.mean_power for one in own.found.values()) / len(own.found)
        assert row["margin"] == pytest.approx(min(margins), rel=1e-9)
        assert row["power"] == pytest.approx(power, rel=1e-9)
        assert row["able"] == (min(margins) >= 1.0)
    assert found[2]["able"] is False
    assert "no-such-motor" in found[2]["words"]


def test_parts_are_sorted_and_wrong_requests_refused():
    opened("knee_walking")
    for sort, sign in (("mass", 1), ("-mass", -1)):
        listed = answered("parts", {"kind": "motors", "query": "maxon", "limit": 100, "sort": sort}).header["rows"]
        masses = [sign * row["values"]["mass"] for row in listed if row["values"]["mass"] is not None]
        assert masses == sorted(masses)
        assert all(row["values"]["mass"] is None for row in listed[len(masses) :])
    with pytest.raises(RefusedError, match="sort"):
        answered("parts", {"kind": "motors", "sort": "__class__"})
    asked = {
        **opened("knee_walking"),
        "drive": "cobotic",
        "at": ["drives", "cobotic", "motor", "part"],
        "parts": ["re-40-24v"],
    }
    for change in (
        {"drive": "no"},
        {"at": []},
        {"at": "drives"},
        {"parts": [3]},
        {"parts": ["x"] * 99},
        {"at": ["title", "x"]},
    ):
        with pytest.raises(RefusedError):
            answered("tried", {**asked, **change})


@pytest.fixture
def page(browser, server):
    with Page(browser, server.address) as found:
        found.ready().opened("knee_walking")
        found.page.get_by_role("tab", name="Designs").click()
        yield found


def settled(page):
    page.page.locator("[aria-label='Designs side by side'][aria-busy=false]").wait_for()
    return page.page.locator("table.designs")


def keep(page, name=""):
    page.field("Name").fill(name)
    page.page.get_by_role("button", name="Keep this design").click()
    return settled(page)


def cells(table, label):
    row = table.locator("tbody tr").filter(has=table.page.locator("th", has_text=label)).first
    return row.locator("td")


@pytest.mark.slow
class TestPage:
    def test_designs_stand_side_by_side_and_come_back(self, page):
        keep(page, "first")
        page.enter("Cylinder speed", "12 rad/s")
        keep(page)
        page.by_id("glance").get_by_role("button", name="Geared").click()
        table = settled(page)
        table.locator("thead th", has_text="now").wait_for()
        settled(page)
        able = ["✓" in one for one in table.locator("thead th").all_inner_texts()[1:]]
        assert able == [True, False, True]  # at 12 rad/s it is too slow
        assert [one.strip() for one in cells(table, "Changes").all_inner_texts()] == [
            "none",
            "Cylinder speed 12 rad/s",
            "none",
        ]
        texts = cells(table, "Hottest winding").all_inner_texts()
        values = [float(one.split()[0]) for one in texts]
        assert ["best" in one for one in texts] == [one == min(values[0], values[2]) for one in values]
        margins = cells(table, "Margin").all_inner_texts()
        assert sum("best" in one for one in margins) == 1
        page.page.get_by_label("windings warm from cold for").fill("2")
        page.page.get_by_label("windings warm from cold for").press("Tab")
        settled(page)
        cooler = [float(one.split()[0]) for one in cells(table, "Hottest winding").all_inner_texts()]
        assert all(early < late for early, late in zip(cooler, values, strict=True))
        page.page.get_by_role("button", name="first", exact=True).click()
        page.settled()
        assert page.field("Cylinder speed").input_value() == "14 rad/s"
        assert table.locator("thead th[aria-current=true]").inner_text().startswith("first")
        page.by_id("undo").click()
        page.settled()
        assert page.field("Cylinder speed").input_value() == "12 rad/s"
        assert page.problems == []

    def test_the_address_holds_designs_and_eight_are_the_most(self, page, browser):
        for speed in range(11, 19):
            page.enter("Cylinder speed", f"{speed} rad/s")
            keep(page, f"at {speed}")
        assert page.page.get_by_role("button", name="Keep this design").is_disabled()
        page.page.get_by_role("button", name="Remove at 12").click()
        settled(page)
        names = [f"at {speed}" for speed in range(11, 19) if speed != 12]
        page.page.wait_for_timeout(500)  # the address follows the state
        with Page(browser, page.page.url) as other:
            other.ready()
            other.page.get_by_role("tab", name="Designs").click()
            table = settled(other)
            found = table.locator("thead button:not(.plain)").all_inner_texts()
            assert found == names
            assert cells(table, "Margin").all_inner_texts() == cells(settled(page), "Margin").all_inner_texts()
            assert other.problems == []
        assert page.problems == []

    def test_the_picker_says_what_each_part_would_do_and_sorts_by_it(self, page):
        page.unfold("Motor")
        page.page.get_by_role("button", name="Choose another part: Motor").first.click()
        dialog = page.page.get_by_role("dialog")
        dialog.locator(".about", has_text="W on average, margin 1.02").wait_for()
        page.page.get_by_label("Search the catalogue").fill("maxon, voltage >= 24 V, mass < 600 g")
        dialog.get_by_label("Sort").select_option(label="least power")
        said = [dialog.locator(f".found button small{kind}[data-part]") for kind in ("", ":not(.no)", ".no")]

        def ordered():
            texts, within, beyond = (one.all_inner_texts() for one in said)
            if not all(texts) or not within or texts != [*within, *beyond]:
                return False
            powers = [float(text.split(" W")[0]) for text in within]
            return len(powers) > 1 and powers == sorted(powers)

        page.until(ordered)
        assert page.problems == []

    @pytest.mark.parametrize("size", sorted(SIZES))
    def test_the_table_fits_every_window(self, browser, server, size):
        with Page(browser, server.address, size) as page:
            page.ready()
            page.page.get_by_role("tab", name="Designs").click()
            keep(page, "a name that is rather long for the head of a column")
            assert page.fits()
            assert page.problems == []
