# SPDX-License-Identifier: GPL-3.0-or-later
"""Segmentation of many meshes: each in a process of its own, on this machine or on Dask."""
