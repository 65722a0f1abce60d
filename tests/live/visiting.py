"""What tests do on the page of the live arena."""

from __future__ import annotations

from playwright.sync_api import expect


def step_of(page):
    return int(page.locator("#now").inner_text().replace(",", ""))


def play_to_the_end(page):
    """Play fast, until time stops."""
    while page.locator("#speed").inner_text() != "3,000 steps / s":
        page.keyboard.press("+")
    page.keyboard.press(" ")
    expect(page.locator("#now")).to_have_text(page.locator("#last").inner_text(), timeout=20_000)
    expect(page.locator("#play")).to_have_attribute("aria-label", "Play")


def change(page, path, value):
    control = page.locator(f"[data-path='{path}']")
    control.fill(value)
    control.press("Tab")
    return control


def focus_nothing(page):
    page.locator("h1").click()
