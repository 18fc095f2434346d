/* What every version of the interface has. */
#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
/* Functions that this model has no use for ignore what they are given. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#else
#define EXPORTED
#endif

#define CHECK(condition, message)                \
    do {                                         \
        if (!(condition)) {                      \
            return @_refuse(instance, message); \
        }                                        \
    } while (0)
#define INSTANCE                     \
    @_instance *const instance = (@_instance *)i; \
    if (instance == NULL) {          \
        return fmi3Error;            \
    }
#define UNUSED(name, parameters)                                            \
    EXPORTED fmi3Status name parameters                                     \
    {                                                                       \
        return @_refuse((const @_instance *)i, #name ": not offered by this model"); \
    }

EXPORTED fmi3Status fmi3ExitInitializationMode(fmi3Instance i)
{
    INSTANCE
    CHECK(instance->data.phase == @@_INITIALIZING,
            "fmi3ExitInitializationMode: initialization was not entered");
    CHECK(@_sample(&instance->data, instance->data.time_s, 0.0), "fmi3ExitInitializationMode: //%here failure");
    instance->data.phase = @@_STEPPING;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3Terminate(fmi3Instance i)
{
    INSTANCE
    CHECK(instance->data.phase == @@_STEPPING, "fmi3Terminate: only between steps");
    instance->data.phase = @@_TERMINATED;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3Reset(fmi3Instance i)
{
    INSTANCE
    @_start(&instance->data);
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetFMUState(fmi3Instance i, fmi3FMUState *state)
{
    INSTANCE
    CHECK(state != NULL, "fmi3GetFMUState: a null pointer");
    CHECK(@_copy(&instance->data, state), "fmi3GetFMUState: out of memory");
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetFMUState(fmi3Instance i, fmi3FMUState state)
{
    INSTANCE
    CHECK(@_restore(&instance->data, state), "fmi3SetFMUState: no state of this model");
    return fmi3OK;
}

EXPORTED fmi3Status fmi3FreeFMUState(fmi3Instance i, fmi3FMUState *state)
{
    INSTANCE
    if (state != NULL) {
        @_forget(&instance->data, *state);
        *state = NULL;
    }
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState state, size_t *size)
{
    INSTANCE
    CHECK(state != NULL && size != NULL, "fmi3SerializedFMUStateSize: a null pointer");
    CHECK(@_size(&instance->data, state, size), "fmi3SerializedFMUStateSize: no state of this instance");
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState state, uint8_t bytes[], size_t size)
{
    INSTANCE
    CHECK(state != NULL && bytes != NULL, "fmi3SerializeFMUState: a null pointer");
    CHECK(@_pack(&instance->data, state, bytes, size),
            "fmi3SerializeFMUState: too few bytes, or no state of this instance");
    return fmi3OK;
}

EXPORTED fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const uint8_t bytes[], size_t size,
        fmi3FMUState *state)
{
    INSTANCE
    CHECK(state != NULL, "fmi3DeserializeFMUState: a null pointer");
    CHECK(@_unpack(&instance->data, bytes, size, state), "fmi3DeserializeFMUState: no state of this model");
    return fmi3OK;
}

