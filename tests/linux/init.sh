#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# The guest's first process. Its root is the host's, read-only; it lays a tmpfs over that, runs
# $SHARE/command in there, leaves the exit status in $SHARE/status and switches the machine off.
# The share is all of the host that can be written to.
PATH=/usr/sbin:/usr/bin:/sbin:/bin
export PATH

die() {
	echo "guest: $1"
	off
}

off() {
	exec python3 -c 'import ctypes; ctypes.CDLL(None).reboot(0x4321FEDC)'
}

new=/mnt/root
mount -t proc proc /proc || die "no /proc"
mount -t tmpfs tmpfs /mnt || die "no tmpfs"
mkdir /mnt/upper /mnt/work $new
mount -t overlay overlay -o lowerdir=/,upperdir=/mnt/upper,workdir=/mnt/work $new || die "no overlay"
mount -t proc proc $new/proc
mount -t sysfs sysfs $new/sys
mount -t configfs configfs $new/sys/kernel/config
mount -t devtmpfs devtmpfs $new/dev
mkdir -p $new/dev/pts $new/dev/shm
mount -t devpts devpts $new/dev/pts
mount -t tmpfs tmpfs $new/dev/shm
ln -sf /proc/self/fd $new/dev/fd
# The folder as mount(2) takes it: fsconfig(), which a newer mount prefers, would need a name for it.
LIBMOUNT_FORCE_MOUNT2=always mount -t hostfs hostfs -o "$SHARE" "$new$SHARE" || die "no share"
ip link set lo up

chroot $new /bin/sh "$SHARE/command" </dev/null
echo $? >"$new$SHARE/status"
off
