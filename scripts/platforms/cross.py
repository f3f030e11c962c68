"""Builds for other machines than this one."""

from .common import Failure


def win64(row):
    raise Failure("not yet")


def aarch64(row):
    raise Failure("not yet")
