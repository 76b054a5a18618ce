# SPDX-License-Identifier: Apache-2.0
"""What the MAVLink dialect is generated from; links to the firmware's own files."""
