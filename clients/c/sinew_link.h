/* A client of a Sinew link in one header: C99 and POSIX sockets, nothing else. docs/link.md documents every byte.
 *
 *   #define SINEW_LINK_IMPLEMENTATION    in one source file
 *   #include "sinew_link.h"
 *
 * Nothing is allocated. Numbers are little endian on the wire whatever the processor. */
#ifndef SINEW_LINK_H
#define SINEW_LINK_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SINEW_OFF, SINEW_READY, SINEW_PRETENSION, SINEW_HOLD, SINEW_RUN, SINEW_SAFE_STOP, SINEW_FAULT };
enum {
    SINEW_ASK_NOTHING, SINEW_ASK_TURN_OFF, SINEW_ASK_GET_READY, SINEW_ASK_PRETENSION, SINEW_ASK_HOLD, SINEW_ASK_RUN,
    SINEW_ASK_SAFE_STOP, SINEW_ASK_RESET
};
enum { SINEW_NONE, SINEW_JOINT, SINEW_MUSCLE_LENGTH, SINEW_TENSION, SINEW_END_POINT };

#define SINEW_MAX_JOINTS 64
#define SINEW_MAX_MUSCLES 128
#define SINEW_MAX_DATAGRAM 1232

/* A number that has never been known is NaN. */
typedef struct { double joint_estimated, joint_velocity, joint_reference; } sinew_joint;
typedef struct { double tension_in_n, tension_out_estimated_n, position_in_m, command, current_a, temperature_degc, setpoint_age_us; } sinew_muscle;

typedef struct {
    uint64_t machine_time_ns, cycle, accepted, lost, rejected, late;
    unsigned mode, request, setpoint, flags, fault, fault_index, queued, last_rejection;
    unsigned joints, muscles;
    double end_point[3];
    sinew_joint joint[SINEW_MAX_JOINTS];
    sinew_muscle muscle[SINEW_MAX_MUSCLES];
} sinew_state;

typedef struct {
    int socket;
    uint8_t client_key[32], host_key[32];
    uint64_t session, sent, newest, newest_sent_ns, newest_arrived_ns, reflected;
    unsigned stop;                        /* asked for and not yet taken, or 0 */
    uint64_t stop_sequence, stop_advance_ns; /* of the packet that asked for it first */
    unsigned joints, muscles, features;
    uint64_t round_trip_ns; /* of the newest packet */
    uint64_t received;      /* datagrams of this session; those lost are newest - received */
    sinew_state state;
} sinew_link;

/* A session; 0, or -1 where none could be had in time (errno says why where a system call failed). `key` may be NULL. */
int sinew_link_open(sinew_link *link, const char *address, unsigned port, const uint8_t key[32], double seconds);
/* Reads a key file of 64 hexadecimal digits; 0 or -1. */
int sinew_link_read_key(const char *file, uint8_t key[32]);
/* Sends a request and `points` set-points of `values` numbers each, with time stamps (0: on arrival); 0 or -1. */
int sinew_link_command(sinew_link *link, unsigned request, unsigned setpoint, const uint64_t *at_ns, const double *numbers,
                       unsigned values, unsigned points, uint64_t advance_to_ns);
/* Waits for the next complete state; 1 with a new link->state, 0 after `seconds`. */
int sinew_link_receive(sinew_link *link, double seconds);
/* The same as sinew_link_open, for a session that watches beside the client that commands: it begins with the first
 * sinew_link_watch, is kept by one every 0.1 s, and takes no commands. */
int sinew_link_open_to_watch(sinew_link *link, const char *address, unsigned port, const uint8_t key[32], double seconds);
int sinew_link_watch(sinew_link *link);
/* Ends the session. Where a stop was asked for (SAFE_STOP, GET_READY, TURN_OFF), first asks again until the machine has taken it, at
 * most a second; 0, or -1 where no state has shown it by then. */
int sinew_link_close(sinew_link *link);

#ifdef __cplusplus
}
#endif

#ifdef SINEW_LINK_IMPLEMENTATION

#include <errno.h>
#include <netdb.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

/* SHA-256: FIPS 180-4. */

static const uint32_t sinew_k[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01,
    0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc,
    0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147,
    0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08,
    0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208,
    0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

typedef struct { uint32_t h[8]; uint8_t block[64]; uint64_t size; } sinew_sha;

static uint32_t sinew_ror(uint32_t x, int n) { return x >> n | x << (32 - n); }

static void sinew_sha_block(sinew_sha *s) {
    uint32_t w[64], v[8];
    for (int i = 0; i < 16; i++)
        w[i] = (uint32_t)s->block[4 * i] << 24 | (uint32_t)s->block[4 * i + 1] << 16 | (uint32_t)s->block[4 * i + 2] << 8 |
               s->block[4 * i + 3];
    for (int i = 16; i < 64; i++) {
        uint32_t a = w[i - 15], b = w[i - 2];
        w[i] = w[i - 16] + (sinew_ror(a, 7) ^ sinew_ror(a, 18) ^ a >> 3) + w[i - 7] +
               (sinew_ror(b, 17) ^ sinew_ror(b, 19) ^ b >> 10);
    }
    memcpy(v, s->h, sizeof v);
    for (int i = 0; i < 64; i++) {
        uint32_t a = v[0], e = v[4];
        uint32_t one = v[7] + (sinew_ror(e, 6) ^ sinew_ror(e, 11) ^ sinew_ror(e, 25)) + ((e & v[5]) ^ (~e & v[6])) +
                       sinew_k[i] + w[i];
        uint32_t two = (sinew_ror(a, 2) ^ sinew_ror(a, 13) ^ sinew_ror(a, 22)) + ((a & v[1]) ^ (a & v[2]) ^ (v[1] & v[2]));
        memmove(v + 1, v, 7 * sizeof *v);
        v[4] += one;
        v[0] = one + two;
    }
    for (int i = 0; i < 8; i++) s->h[i] += v[i];
}

static void sinew_sha_begin(sinew_sha *s) {
    static const uint32_t h[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    memcpy(s->h, h, sizeof h);
    s->size = 0;
}

static void sinew_sha_add(sinew_sha *s, const void *data, size_t size) {
    const uint8_t *bytes = (const uint8_t *)data;
    while (size--) {
        s->block[s->size++ & 63] = *bytes++;
        if (!(s->size & 63)) sinew_sha_block(s);
    }
}

static void sinew_sha_end(sinew_sha *s, uint8_t digest[32]) {
    uint64_t bits = 8 * s->size;
    uint8_t end[8];
    const uint8_t one = 0x80, zero = 0;
    sinew_sha_add(s, &one, 1);
    while ((s->size & 63) != 56) sinew_sha_add(s, &zero, 1);
    for (int i = 0; i < 8; i++) end[i] = (uint8_t)(bits >> (56 - 8 * i));
    sinew_sha_add(s, end, 8);
    for (int i = 0; i < 32; i++) digest[i] = (uint8_t)(s->h[i / 4] >> (24 - 8 * (i % 4)));
}

/* HMAC: RFC 2104, with a key of 32 bytes, over two pieces. */
static void sinew_hmac(const uint8_t key[32], const void *a, size_t na, const void *b, size_t nb, uint8_t tag[32]) {
    sinew_sha s;
    uint8_t pad[64];
    for (int i = 0; i < 64; i++) pad[i] = (uint8_t)((i < 32 ? key[i] : 0) ^ 0x36);
    sinew_sha_begin(&s), sinew_sha_add(&s, pad, 64), sinew_sha_add(&s, a, na), sinew_sha_add(&s, b, nb), sinew_sha_end(&s, tag);
    for (int i = 0; i < 64; i++) pad[i] ^= 0x36 ^ 0x5c;
    sinew_sha_begin(&s), sinew_sha_add(&s, pad, 64), sinew_sha_add(&s, tag, 32), sinew_sha_end(&s, tag);
}

/* Packets. */

enum { SINEW_HEAD = 56, SINEW_TAG = 32, SINEW_STATE = 100, SINEW_HELLO_SIZE = 104 };

static uint64_t sinew_now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static uint8_t *sinew_put(uint8_t *at, uint64_t x, int size) {
    for (int i = 0; i < size; i++) *at++ = (uint8_t)(x >> 8 * i);
    return at;
}

static uint64_t sinew_get(const uint8_t *at, int size) {
    uint64_t x = 0;
    while (size--) x = x << 8 | at[size];
    return x;
}

static double sinew_get_double(const uint8_t *at) {
    uint64_t bits = sinew_get(at, 8);
    double x;
    memcpy(&x, &bits, 8);
    return x;
}

/* Completes a datagram whose body is in place, and sends it. */
static int sinew_send(sinew_link *link, unsigned kind, uint8_t *datagram, size_t body) {
    uint64_t now = sinew_now();
    uint8_t *at = datagram;
    memcpy(at, "SNWL", 4);
    at = sinew_put(at + 4, 2, 1), at = sinew_put(at, kind, 1), at = sinew_put(at, SINEW_HEAD + body + SINEW_TAG, 2);
    at = sinew_put(at, link->session, 8), at = sinew_put(at, link->session ? ++link->sent : 0, 8);
    at = sinew_put(at, link->newest, 8), at = sinew_put(at, now, 8), at = sinew_put(at, link->newest_sent_ns, 8);
    sinew_put(at, link->newest ? now - link->newest_arrived_ns : 0, 8);
    sinew_hmac(link->client_key, datagram, SINEW_HEAD + body, "", 0, datagram + SINEW_HEAD + body);
    ssize_t size = (ssize_t)(SINEW_HEAD + body + SINEW_TAG);
    return send(link->socket, datagram, (size_t)size, 0) == size ? 0 : -1;
}

/* The next valid datagram of a kind; bytes of its body, -1 after `end`. */
static int sinew_next(sinew_link *link, unsigned kind, uint8_t *datagram, uint64_t end) {
    for (;;) {
        uint64_t now = sinew_now();
        struct pollfd ready = {link->socket, POLLIN, 0};
        if (now >= end || poll(&ready, 1, (int)((end - now) / 1000000u) + 1) < 0) return -1;
        ssize_t size = recv(link->socket, datagram, SINEW_MAX_DATAGRAM + 1, MSG_DONTWAIT);
        if (size < SINEW_HEAD + SINEW_TAG || size > SINEW_MAX_DATAGRAM) continue;
        size_t sealed = (size_t)size - SINEW_TAG;
        uint8_t tag[32], differs = 0;
        sinew_hmac(link->host_key, datagram, sealed, "", 0, tag);
        for (int i = 0; i < 32; i++) differs |= (uint8_t)(tag[i] ^ datagram[sealed + (size_t)i]);
        if (differs || memcmp(datagram, "SNWL\2", 5) || datagram[5] != kind) continue;
        if (sinew_get(datagram + 6, 2) != (uint64_t)size || sinew_get(datagram + 8, 8) != link->session) continue;
        if (link->session) {
            uint64_t sequence = sinew_get(datagram + 16, 8);
            if (sequence <= link->newest) continue;
            link->newest = sequence, link->received++;
            link->newest_sent_ns = sinew_get(datagram + 32, 8), link->newest_arrived_ns = now = sinew_now();
            link->reflected = sinew_get(datagram + 24, 8);
            if (sinew_get(datagram + 24, 8))
                link->round_trip_ns = now - sinew_get(datagram + 40, 8) - sinew_get(datagram + 48, 8);
        }
        return (int)(sealed - SINEW_HEAD);
    }
}

static int sinew_open(sinew_link *link, const char *address, unsigned port, const uint8_t key[32], double seconds,
                      uint8_t role) {
    uint8_t datagram[SINEW_MAX_DATAGRAM + 1], nonce[16], none[32] = {0};
    char service[8];
    struct addrinfo hints, *found;
    memset(link, 0, sizeof *link);
    memset(&hints, 0, sizeof hints);
    hints.ai_socktype = SOCK_DGRAM;
    snprintf(service, sizeof service, "%u", port & 0xffff);
    FILE *random = fopen("/dev/urandom", "rb");
    size_t got = random ? fread(nonce, 1, sizeof nonce, random) : 0;
    if (random) fclose(random);
    if (got != sizeof nonce || getaddrinfo(address, service, &hints, &found)) return -1;
    link->socket = socket(found->ai_family, SOCK_DGRAM, 0);
    int bad = link->socket < 0 || connect(link->socket, found->ai_addr, found->ai_addrlen);
    freeaddrinfo(found);
    memcpy(link->client_key, key ? key : none, 32), memcpy(link->host_key, key ? key : none, 32);
    uint64_t end = sinew_now() + (uint64_t)(seconds * 1e9);
    while (!bad && sinew_now() < end) {
        uint8_t *body = datagram + SINEW_HEAD;
        memcpy(body, nonce, 16), memset(body + 16, 0, SINEW_HELLO_SIZE - 16), body[16] = role;
        sinew_send(link, 1, datagram, SINEW_HELLO_SIZE);
        int size = sinew_next(link, 2, datagram, sinew_now() + 100000000u);
        if (size != SINEW_HELLO_SIZE || memcmp(body, nonce, 16)) continue;
        link->session = sinew_get(body + 16, 8);
        link->joints = (unsigned)sinew_get(body + 64, 2), link->muscles = (unsigned)sinew_get(body + 66, 2);
        link->features = (unsigned)sinew_get(body + 68, 4);
        uint8_t base[32];
        memcpy(base, link->client_key, 32);
        sinew_hmac(base, "sinew-link 1 client", 19, body, 32, link->client_key);
        sinew_hmac(base, "sinew-link 1 host", 17, body, 32, link->host_key);
        memset(base, 0, 32);
        return 0;
    }
    if (link->socket >= 0) close(link->socket);
    return -1;
}

int sinew_link_open(sinew_link *link, const char *address, unsigned port, const uint8_t key[32], double seconds) {
    return sinew_open(link, address, port, key, seconds, 0);
}

int sinew_link_open_to_watch(sinew_link *link, const char *address, unsigned port, const uint8_t key[32], double seconds) {
    return sinew_open(link, address, port, key, seconds, 1);
}

int sinew_link_watch(sinew_link *link) {
    uint8_t datagram[SINEW_MAX_DATAGRAM];
    return sinew_send(link, 7, datagram, 0);
}

int sinew_link_read_key(const char *file, uint8_t key[32]) {
    FILE *in = fopen(file, "r");
    int good = in != NULL;
    for (int i = 0; i < 32 && good; i++) {
        unsigned byte = 0;
        good = fscanf(in, "%2x", &byte) == 1;
        key[i] = (uint8_t)byte;
    }
    if (in) fclose(in);
    return good ? 0 : -1;
}

int sinew_link_command(sinew_link *link, unsigned request, unsigned setpoint, const uint64_t *at_ns, const double *numbers,
                       unsigned values, unsigned points, uint64_t advance_to_ns) {
    uint8_t datagram[SINEW_MAX_DATAGRAM], *at = datagram + SINEW_HEAD;
    size_t body = 16 + (size_t)points * (8 + 8 * (size_t)values);
    if (values > SINEW_MAX_MUSCLES || body > sizeof datagram - SINEW_HEAD - SINEW_TAG) return errno = EMSGSIZE, -1;
    int stops = request == SINEW_ASK_TURN_OFF || request == SINEW_ASK_GET_READY || request == SINEW_ASK_SAFE_STOP;
    if (request && !stops) link->stop = 0;
    if (stops && (link->stop != request || link->stop_advance_ns != advance_to_ns))
        link->stop = request, link->stop_sequence = link->sent + 1, link->stop_advance_ns = advance_to_ns;
    at = sinew_put(at, request, 1), at = sinew_put(at, setpoint, 1), at = sinew_put(at, values, 2);
    at = sinew_put(at, points, 4), at = sinew_put(at, advance_to_ns, 8);
    for (unsigned i = 0; i < points; i++) {
        at = sinew_put(at, at_ns ? at_ns[i] : 0, 8);
        for (unsigned k = 0; k < values; k++) {
            uint64_t bits;
            memcpy(&bits, &numbers[i * values + k], 8);
            at = sinew_put(at, bits, 8);
        }
    }
    return sinew_send(link, 4, datagram, body);
}

static void sinew_numbers(double *to, const uint8_t *from, size_t size) {
    for (size_t i = 0; i < size / 8; i++) to[i] = sinew_get_double(from + 8 * i);
}

/* Takes one part of a state; 1 where it was the last. */
static int sinew_take(sinew_state *s, const uint8_t *b, size_t size) {
    if (size < SINEW_STATE) return 0;
    unsigned joints = (unsigned)sinew_get(b + 88, 2), muscles = (unsigned)sinew_get(b + 90, 2);
    unsigned first = (unsigned)sinew_get(b + 92, 2), count = (unsigned)sinew_get(b + 94, 2);
    unsigned first_muscle = (unsigned)sinew_get(b + 96, 2), muscle_count = (unsigned)sinew_get(b + 98, 2);
    if (joints > SINEW_MAX_JOINTS || muscles > SINEW_MAX_MUSCLES || first + count > joints) return 0;
    size_t joint = sinew_get(b + 27, 2), muscle = sinew_get(b + 29, 2); /* a newer host sends more numbers of each */
    if (joint < sizeof(sinew_joint) || muscle < sizeof(sinew_muscle)) return 0;
    if (first_muscle + muscle_count > muscles || size != SINEW_STATE + joint * count + muscle * muscle_count) return 0;
    s->machine_time_ns = sinew_get(b, 8), s->cycle = sinew_get(b + 8, 8);
    s->mode = b[16], s->request = b[17], s->setpoint = b[18], s->flags = b[19];
    s->fault = (unsigned)sinew_get(b + 20, 2), s->fault_index = (unsigned)sinew_get(b + 22, 2);
    s->queued = (unsigned)sinew_get(b + 24, 2), s->last_rejection = b[26];
    s->accepted = sinew_get(b + 32, 8), s->lost = sinew_get(b + 40, 8);
    s->rejected = sinew_get(b + 48, 8), s->late = sinew_get(b + 56, 8);
    for (int i = 0; i < 3; i++) s->end_point[i] = sinew_get_double(b + 64 + 8 * i);
    s->joints = joints, s->muscles = muscles;
    b += SINEW_STATE;
    for (unsigned i = first; i < first + count; i++, b += joint) sinew_numbers((double *)&s->joint[i], b, sizeof s->joint[i]);
    for (unsigned i = first_muscle; i < first_muscle + muscle_count; i++, b += muscle)
        sinew_numbers((double *)&s->muscle[i], b, sizeof s->muscle[i]);
    return first + count == joints && first_muscle + muscle_count == muscles;
}

int sinew_link_receive(sinew_link *link, double seconds) {
    uint8_t datagram[SINEW_MAX_DATAGRAM + 1];
    uint64_t end = sinew_now() + (uint64_t)(seconds * 1e9);
    for (;;) {
        int size = sinew_next(link, 5, datagram, end);
        if (size < 0) return 0;
        if (!sinew_take(&link->state, datagram + SINEW_HEAD, (size_t)size)) continue;
        if (link->state.request == link->stop && link->reflected >= link->stop_sequence) link->stop = 0;
        return 1;
    }
}

int sinew_link_close(sinew_link *link) {
    uint8_t datagram[SINEW_MAX_DATAGRAM];
    uint64_t end = sinew_now() + 1000000000u;
    while (link->stop && sinew_now() < end) {
        sinew_link_command(link, link->stop, SINEW_NONE, NULL, NULL, 0, 0, link->stop_advance_ns);
        sinew_link_receive(link, 0.02);
    }
    sinew_send(link, 6, datagram, 0);
    close(link->socket);
    memset(link->client_key, 0, 32), memset(link->host_key, 0, 32);
    return link->stop ? -1 : 0;
}

#endif
#endif
