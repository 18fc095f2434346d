/* FMI 2.0 for co-simulation; https://fmi-standard.org.
 *
//%if plant
 * A step from t to t + h takes the inputs that were set before it; outputs are those of the time t + h.
//%else
 * A step from t to t + h takes the sample of the time t + h with the inputs that were set before it: an
 * importer that sets them for t sees one step of delay.
//%end
 */
#include "core.h"

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef void *fmi2Component;
typedef void *fmi2FMUstate;
typedef unsigned fmi2ValueReference;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef struct {
    void (*log)(void *, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, fmi2Status);
    void *environment;
} fmi2CallbackFunctions;

typedef struct {
    @_data data;
    fmi2CallbackFunctions callbacks;
} @_instance;

static fmi2Status @_refuse(const @_instance *instance, const char *message)
{
    if (instance != NULL && instance->callbacks.log != NULL) {
        instance->callbacks.log(instance->callbacks.environment, "@", fmi2Error, "logStatusError", "%s",
                message);
    }
    return fmi2Error;
}

//%include calls
/* Types of which the model has no variable: none may be asked for. */
#define NONE(name, type)                                                                                     \
    EXPORTED fmi2Status fmi2Get##name(fmi2Component i, const fmi2ValueReference r[], size_t n, type v[])     \
    {                                                                                                        \
        INSTANCE                                                                                             \
        CHECK(n == 0, "fmi2Get" #name ": no variable has this type");                                        \
        return fmi2OK;                                                                                       \
    }                                                                                                        \
    EXPORTED fmi2Status fmi2Set##name(fmi2Component i, const fmi2ValueReference r[], size_t n, \
            const type v[]) \
    {                                                                                                        \
        INSTANCE                                                                                             \
        CHECK(n == 0, "fmi2Set" #name ": no variable has this type");                                        \
        return fmi2OK;                                                                                       \
    }

EXPORTED const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORTED const char *fmi2GetVersion(void)
{
    return "2.0";
}

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component i, fmi2Boolean on, size_t n,
        const fmi2String categories[])
{
    return i == NULL ? fmi2Error : fmi2OK;
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, int type, fmi2String token, fmi2String resources,
                                       const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                                               fmi2Boolean logging)
{
    @_instance *instance;
    /* 1: co-simulation. */
    if (name == NULL || token == NULL || type != 1 || strcmp(token, "//%here token") != 0) {
        return NULL;
    }
    instance = (@_instance *)calloc(1, sizeof *instance);
    if (instance != NULL) {
        if (callbacks != NULL) {
            instance->callbacks = *callbacks;
        }
//%if plant
        if (!@_find(&instance->data, resources)) {
            free(instance);
            return NULL;
        }
//%end
        @_start(&instance->data);
    }
    return instance;
}

EXPORTED void fmi2FreeInstance(fmi2Component i)
{
//%if plant
    @_instance *const instance = (@_instance *)i;
    if (instance != NULL) {
        @_end(&instance->data);
        free(instance->data.path);
    }
//%end
    free(i);
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component i, fmi2Boolean tolerated, double tolerance,
        double start,
                                        fmi2Boolean stops, double stop)
{
    INSTANCE
    CHECK(instance->data.phase == @@_INSTANTIATED, "fmi2SetupExperiment: only after instantiation or reset");
    CHECK(@_is_number(start), "fmi2SetupExperiment: the start time is no number");
    instance->data.time_s = start;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component i)
{
    INSTANCE
    CHECK(instance->data.phase == @@_INSTANTIATED,
            "fmi2EnterInitializationMode: only after instantiation or reset");
    instance->data.phase = @@_INITIALIZING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component i, double time_s, double step_s, fmi2Boolean final)
{
    INSTANCE
    CHECK(instance->data.phase == @@_STEPPING, "fmi2DoStep: only after initialization");
    CHECK(@_continues(&instance->data, time_s, step_s),
          "fmi2DoStep: expected the time of the last step, and a step above zero");
    CHECK(@_sample(&instance->data, time_s + step_s, step_s), "fmi2DoStep: //%here failure");
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component i, const fmi2ValueReference r[], size_t n, double v[])
{
    size_t k;
    INSTANCE
    CHECK(n == 0 || (r != NULL && v != NULL), "fmi2GetReal: a null pointer");
    for (k = 0; k < n; k++) {
        CHECK(@_get(&instance->data, r[k], &v[k]), "fmi2GetReal: no such variable of this type");
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component i, const fmi2ValueReference r[], size_t n, const double v[])
{
    size_t k;
    INSTANCE
    CHECK(n == 0 || (r != NULL && v != NULL), "fmi2SetReal: a null pointer");
    CHECK(instance->data.phase != @@_TERMINATED, "fmi2SetReal: the instance is terminated");
    for (k = 0; k < n; k++) {
        CHECK(@_set(&instance->data, r[k], v[k]), "fmi2SetReal: only inputs can be set");
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component i, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
{
    size_t k;
    INSTANCE
    CHECK(n == 0 || (r != NULL && v != NULL), "fmi2GetBoolean: a null pointer");
    for (k = 0; k < n; k++) {
        CHECK(@_flag(&instance->data, r[k], &v[k]), "fmi2GetBoolean: no such variable of this type");
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component i, const fmi2ValueReference r[], size_t n,
        const fmi2Boolean v[])
{
    INSTANCE
    CHECK(n == 0, "fmi2SetBoolean: no input has this type");
    return fmi2OK;
}

NONE(Integer, int)
NONE(String, fmi2String)

UNUSED(fmi2GetDirectionalDerivative, (fmi2Component i, const fmi2ValueReference a[], size_t n,
                                      const fmi2ValueReference b[], size_t m, const double c[], double d[]))
UNUSED(fmi2SetRealInputDerivatives,
       (fmi2Component i, const fmi2ValueReference r[], size_t n, const int orders[], const double v[]))
UNUSED(fmi2GetRealOutputDerivatives,
       (fmi2Component i, const fmi2ValueReference r[], size_t n, const int orders[], double v[]))
UNUSED(fmi2CancelStep, (fmi2Component i))
UNUSED(fmi2GetStatus, (fmi2Component i, int kind, fmi2Status *value))
UNUSED(fmi2GetRealStatus, (fmi2Component i, int kind, double *value))
UNUSED(fmi2GetIntegerStatus, (fmi2Component i, int kind, int *value))
UNUSED(fmi2GetBooleanStatus, (fmi2Component i, int kind, fmi2Boolean *value))
UNUSED(fmi2GetStringStatus, (fmi2Component i, int kind, fmi2String *value))
