/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The yardstick: a blocking UDP echo on loopback. Prints its port, then sends every datagram back
 * until it is killed.
 */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/types.h>

int main(void)
{
	struct sockaddr_in address = {
		.sin_family = AF_INET,
		.sin_addr.s_addr = htonl(INADDR_LOOPBACK),
	};
	socklen_t length = sizeof(address);
	const int sock = socket(AF_INET, SOCK_DGRAM, 0);

	if (sock < 0 || bind(sock, (struct sockaddr *)&address, sizeof(address)) != 0 ||
	    getsockname(sock, (struct sockaddr *)&address, &length) != 0) {
		perror("udp_echo");
		return EXIT_FAILURE;
	}
	printf("%u\n", (unsigned int)ntohs(address.sin_port));
	(void)fflush(stdout);
	for (;;) {
		char data[2048];
		struct sockaddr_in peer;
		socklen_t peer_length = sizeof(peer);
		const ssize_t size = recvfrom(sock, data, sizeof(data), 0, (struct sockaddr *)&peer,
		                              &peer_length);

		if (size >= 0) {
			(void)sendto(sock, data, (size_t)size, 0, (struct sockaddr *)&peer,
			             peer_length);
		}
	}
}
