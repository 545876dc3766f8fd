# SPDX-License-Identifier: Apache-2.0
"""Galaxy for programs in Python: gxy.insitu publishes the steps of a simulation while it runs."""

__version__ = "0.1.0"
