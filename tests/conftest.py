"""Shared by every test: the seed that random tests use, printed when one fails."""

import os

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--seed", type=int, default=int(os.environ.get("ROBOTSKIN_SEED", "1")), help="seed of random tests")


def pytest_report_header(config: pytest.Config) -> str:
    return f"robotskin seed: {config.getoption('--seed')}"


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    return request.config.getoption("--seed")
