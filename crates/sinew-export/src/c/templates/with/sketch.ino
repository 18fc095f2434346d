/* Sketch for boards whose double has 64 bits (Teensy 3.x and 4.x, ESP32, Due, Portenta; not Uno or Mega).
 * Copy ../../@.h and ../../@.c beside this file. A Teensy 4 computes double in hardware: a step takes
 * microseconds.
 */
#include "@.h"

static @_state state;

/* Reads the inputs of @.h, in its order and units; NAN where a sensor gives nothing. */
static void read_inputs(double *inputs)
{
    for (int i = 0; i < @@_INPUTS; i++) {
        inputs[i] = NAN; /* in the place of this: the sensor's reading */
    }
}

void setup()
{
    Serial.begin(115200);
    @_init(&state);
}

void loop()
{
    static uint32_t next_us = micros();
    static double time_s = 0.0;
    double inputs[@@_INPUTS];
    while ((int32_t)(micros() - next_us) < 0) {
    }
    next_us += 1000;
    time_s += 1e-3;
    read_inputs(inputs);
    const @_prediction p = @_step(&state, time_s, inputs);
    Serial.println(p.mean, 3);
}
