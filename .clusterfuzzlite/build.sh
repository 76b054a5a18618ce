#!/bin/bash -eu
# SPDX-License-Identifier: Apache-2.0
#
# Builds every fuzz harness for OSS-Fuzz and ClusterFuzzLite: compiler and flags come in CC and CFLAGS,
# the engine in LIB_FUZZING_ENGINE, what is built goes to OUT; WORK is for what lies between.
cd "$SRC/pharos"
if [ ! -x .venv/bin/python ]; then
	python3 -m venv "$WORK/venv"
	"$WORK/venv/bin/python" -m pip install -q -r requirements.txt
	python=$WORK/venv/bin/python
else
	python=.venv/bin/python
fi
cmake -G Ninja -S . -B "$WORK/build" -DBOARD=native -DCMAKE_BUILD_TYPE=None \
	-DPython3_EXECUTABLE="$(realpath -s "$python")" \
	-DPHAROS_FUZZ=ON -DPHAROS_FUZZ_ENGINE="$LIB_FUZZING_ENGINE"
ninja -C "$WORK/build" fuzz
find "$WORK/build/tests/fuzz" -maxdepth 1 -name 'fuzz_*' -type f -executable -exec cp {} "$OUT/" \;
