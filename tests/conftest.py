# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for all tests."""

import os

import pytest

# Before any test imports PyMeshLab, which most do before the package: docs/performance.md, "Busy
# machines".
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

# Where CI is set everything is there that tests need, and these are all the reasons to skip one.
REASONS_TO_SKIP = (
    "there is a usable GPU",
    "mounting a small disk needs root",
    "PyMeshLab 2022.2 corrupts its memory when Python adds an attribute",
)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    return _without_silent_skip((yield))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    return _without_silent_skip((yield))


def _without_silent_skip(report):
    if report.skipped and os.environ.get("CI") and not hasattr(report, "wasxfail"):
        *_, reason = report.longrepr
        if reason.removeprefix("Skipped: ") not in REASONS_TO_SKIP:
            report.outcome = "failed"
            report.longrepr = f"{reason} (where CI is set a skip is a failure: tests/conftest.py)"
    return report
