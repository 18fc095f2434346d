/* Moves the first joint of a machine a little, once around a sine, and prints what came back.
 *
 *   cc -std=c99 -O2 -D_POSIX_C_SOURCE=200809L -o example example.c -lm
 *   ./example 127.0.0.1 7500 2.0 [KEY FILE] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define SINEW_LINK_IMPLEMENTATION
#include "sinew_link.h"

int main(int count, char **arguments) {
    static sinew_link robot;
    uint8_t key[32];
    if (count < 4) return fprintf(stderr, "usage: example ADDRESS PORT SECONDS [KEY FILE]\n"), 2;
    int with_key = count > 4;
    if (with_key && sinew_link_read_key(arguments[4], key)) return fprintf(stderr, "error: key file %s\n", arguments[4]), 2;
    double seconds = atof(arguments[3]);
    if (sinew_link_open(&robot, arguments[1], (unsigned)atoi(arguments[2]), with_key ? key : NULL, 5.0))
        return fprintf(stderr, "error: %s: no session\n", arguments[1]), 1;
    double start[SINEW_MAX_JOINTS], desired[SINEW_MAX_JOINTS];
    sinew_link_command(&robot, SINEW_ASK_HOLD, SINEW_NONE, NULL, NULL, 0, 0, 0);
    if (!sinew_link_receive(&robot, 5.0)) return fprintf(stderr, "error: no state\n"), 1;
    for (unsigned i = 0; i < robot.joints; i++) desired[i] = start[i] = robot.state.joint[i].joint_reference;
    uint64_t begin = sinew_now(), states = 0;
    for (;;) {
        double t = (double)(sinew_now() - begin) * 1e-9;
        if (t > seconds) break;
        desired[0] = start[0] + 0.05 * sin(6.283185307179586 * t / seconds);
        sinew_link_command(&robot, SINEW_ASK_RUN, SINEW_JOINT, NULL, desired, robot.joints, 1, 0);
        struct timespec pause = {0, 2000000};
        nanosleep(&pause, NULL);
        while (sinew_link_receive(&robot, 0.0001)) states++;
    }
    printf("{\"states\": %llu, \"accepted\": %llu, \"lost\": %llu, \"mode\": %u, \"first_joint\": %.6f, \"round_trip_us\": %.1f}\n",
           (unsigned long long)states, (unsigned long long)robot.state.accepted, (unsigned long long)robot.state.lost,
           robot.state.mode, robot.state.joint[0].joint_estimated, (double)robot.round_trip_ns * 1e-3);
    return sinew_link_close(&robot) ? 1 : 0;
}
