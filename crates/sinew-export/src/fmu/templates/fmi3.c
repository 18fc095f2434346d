/* FMI 3.0 for co-simulation; https://fmi-standard.org.
 *
//%if plant
 * A step from t to t + h takes the inputs that were set before it; outputs are those of the time t + h.
//%else
 * A step from t to t + h takes the sample of the time t + h with the inputs that were set before it: an
 * importer that sets them for t sees one step of delay.
//%end
 */
#include "core.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;
typedef const uint8_t *fmi3Binary;
typedef void (*fmi3LogMessage)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);

typedef struct {
    @_data data;
    fmi3InstanceEnvironment environment;
    fmi3LogMessage log;
} @_instance;

static fmi3Status @_refuse(const @_instance *instance, const char *message)
{
    if (instance != NULL && instance->log != NULL) {
        instance->log(instance->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

//%include calls
/* Types of which the model has no variable: none may be asked for. */
#define NONE(name, type)                                                                                     \
    EXPORTED fmi3Status fmi3Get##name(fmi3Instance i, const fmi3ValueReference r[], size_t n, type v[], \
            size_t m) \
    {                                                                                                        \
        INSTANCE                                                                                             \
        CHECK(n == 0, "fmi3Get" #name ": no variable has this type");                                        \
        return fmi3OK;                                                                                       \
    }                                                                                                        \
    EXPORTED fmi3Status fmi3Set##name(fmi3Instance i, const fmi3ValueReference r[], size_t n, \
            const type v[], size_t m) \
    {                                                                                                        \
        INSTANCE                                                                                             \
        CHECK(n == 0, "fmi3Set" #name ": no variable has this type");                                        \
        return fmi3OK;                                                                                       \
    }

EXPORTED const char *fmi3GetVersion(void)
{
    return "3.0";
}

EXPORTED fmi3Status fmi3SetDebugLogging(fmi3Instance i, bool on, size_t n, const fmi3String categories[])
{
    return i == NULL ? fmi3Error : fmi3OK;
}

EXPORTED fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token,
        fmi3String resources, bool visible,
                                                  bool logging, bool events, bool early,
                                                  const fmi3ValueReference required[], size_t n,
                                                  fmi3InstanceEnvironment environment, fmi3LogMessage log,
                                                  void (*update)(void))
{
    @_instance *instance;
    if (name == NULL || token == NULL || strcmp(token, "//%here token") != 0) {
        if (log != NULL) {
            log(environment, fmi3Error, "logStatusError", "the instantiation token is that of another model");
        }
        return NULL;
    }
    instance = (@_instance *)calloc(1, sizeof *instance);
    if (instance != NULL) {
        instance->environment = environment;
        instance->log = log;
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

EXPORTED fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                   bool visible, bool logging,
                                                   fmi3InstanceEnvironment environment, fmi3LogMessage log)
{
    return NULL;
}

EXPORTED fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token,
        fmi3String resources,
                                                        bool visible, bool logging,
                                                        fmi3InstanceEnvironment environment,
                                                                fmi3LogMessage log,
                                                        void (*update)(void), void (*lock)(void),
                                                        void (*unlock)(void))
{
    return NULL;
}

EXPORTED void fmi3FreeInstance(fmi3Instance i)
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

EXPORTED fmi3Status fmi3EnterInitializationMode(fmi3Instance i, bool tolerated, double tolerance,
        double start,
                                                bool stops, double stop)
{
    INSTANCE
    CHECK(instance->data.phase == @@_INSTANTIATED,
            "fmi3EnterInitializationMode: only after instantiation or reset");
    CHECK(@_is_number(start), "fmi3EnterInitializationMode: the start time is no number");
    instance->data.time_s = start;
    instance->data.phase = @@_INITIALIZING;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3DoStep(fmi3Instance i, double time_s, double step_s, bool final, bool *event,
                               bool *terminate, bool *early, double *last_s)
{
    INSTANCE
    CHECK(instance->data.phase == @@_STEPPING, "fmi3DoStep: only in step mode");
    CHECK(event != NULL && terminate != NULL && early != NULL && last_s != NULL,
            "fmi3DoStep: a null pointer");
    *event = false;
    *terminate = false;
    *early = false;
    *last_s = instance->data.time_s;
    CHECK(@_continues(&instance->data, time_s, step_s),
          "fmi3DoStep: expected the time of the last step, and a step above zero");
    CHECK(@_sample(&instance->data, time_s + step_s, step_s), "fmi3DoStep: //%here failure");
    *last_s = instance->data.time_s;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference r[], size_t n, double v[],
        size_t m)
{
    size_t k;
    INSTANCE
    CHECK(n == m && (n == 0 || (r != NULL && v != NULL)), "fmi3GetFloat64: one value for each reference");
    for (k = 0; k < n; k++) {
        CHECK(@_get(&instance->data, r[k], &v[k]), "fmi3GetFloat64: no such variable of this type");
    }
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference r[], size_t n,
        const double v[], size_t m)
{
    size_t k;
    INSTANCE
    CHECK(n == m && (n == 0 || (r != NULL && v != NULL)), "fmi3SetFloat64: one value for each reference");
    CHECK(instance->data.phase != @@_TERMINATED, "fmi3SetFloat64: the instance is terminated");
    for (k = 0; k < n; k++) {
        CHECK(@_set(&instance->data, r[k], v[k]), "fmi3SetFloat64: only inputs can be set");
    }
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetBoolean(fmi3Instance i, const fmi3ValueReference r[], size_t n, bool v[], size_t m)
{
    size_t k;
    int flag = 0;
    INSTANCE
    CHECK(n == m && (n == 0 || (r != NULL && v != NULL)), "fmi3GetBoolean: one value for each reference");
    for (k = 0; k < n; k++) {
        CHECK(@_flag(&instance->data, r[k], &flag), "fmi3GetBoolean: no such variable of this type");
        v[k] = flag != 0;
    }
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetBoolean(fmi3Instance i, const fmi3ValueReference r[], size_t n,
        const bool v[], size_t m)
{
    INSTANCE
    CHECK(n == 0, "fmi3SetBoolean: no input has this type");
    return fmi3OK;
}

NONE(Float32, float)
NONE(Int8, int8_t)
NONE(UInt8, uint8_t)
NONE(Int16, int16_t)
NONE(UInt16, uint16_t)
NONE(Int32, int32_t)
NONE(UInt32, uint32_t)
NONE(Int64, int64_t)
NONE(UInt64, uint64_t)
NONE(String, fmi3String)

#define REFERENCES const fmi3ValueReference r[], size_t n

UNUSED(fmi3GetBinary, (fmi3Instance i, REFERENCES, size_t sizes[], fmi3Binary v[], size_t m))
UNUSED(fmi3SetBinary, (fmi3Instance i, REFERENCES, const size_t sizes[], const fmi3Binary v[], size_t m))
UNUSED(fmi3GetClock, (fmi3Instance i, REFERENCES, bool v[]))
UNUSED(fmi3SetClock, (fmi3Instance i, REFERENCES, const bool v[]))
UNUSED(fmi3EnterEventMode, (fmi3Instance i))
UNUSED(fmi3EnterStepMode, (fmi3Instance i))
UNUSED(fmi3EnterContinuousTimeMode, (fmi3Instance i))
UNUSED(fmi3EnterConfigurationMode, (fmi3Instance i))
UNUSED(fmi3ExitConfigurationMode, (fmi3Instance i))
UNUSED(fmi3EvaluateDiscreteStates, (fmi3Instance i))
UNUSED(fmi3UpdateDiscreteStates, (fmi3Instance i, bool *a, bool *b, bool *c, bool *d, bool *e, double *f))
UNUSED(fmi3GetNumberOfVariableDependencies, (fmi3Instance i, fmi3ValueReference r, size_t *n))
UNUSED(fmi3GetVariableDependencies,
       (fmi3Instance i, fmi3ValueReference r, size_t a[], fmi3ValueReference b[], size_t c[], int d[],
               size_t n))
UNUSED(fmi3GetDirectionalDerivative, (fmi3Instance i, REFERENCES, const fmi3ValueReference k[], size_t l,
                                      const double a[], size_t b, double c[], size_t d))
UNUSED(fmi3GetAdjointDerivative, (fmi3Instance i, REFERENCES, const fmi3ValueReference k[], size_t l,
                                  const double a[], size_t b, double c[], size_t d))
UNUSED(fmi3GetOutputDerivatives, (fmi3Instance i, REFERENCES, const int32_t orders[], double v[], size_t m))
UNUSED(fmi3GetIntervalDecimal, (fmi3Instance i, REFERENCES, double v[], int q[]))
UNUSED(fmi3GetIntervalFraction, (fmi3Instance i, REFERENCES, uint64_t a[], uint64_t b[], int q[]))
UNUSED(fmi3GetShiftDecimal, (fmi3Instance i, REFERENCES, double v[]))
UNUSED(fmi3GetShiftFraction, (fmi3Instance i, REFERENCES, uint64_t a[], uint64_t b[]))
UNUSED(fmi3SetIntervalDecimal, (fmi3Instance i, REFERENCES, const double v[]))
UNUSED(fmi3SetIntervalFraction, (fmi3Instance i, REFERENCES, const uint64_t a[], const uint64_t b[]))
UNUSED(fmi3SetShiftDecimal, (fmi3Instance i, REFERENCES, const double v[]))
UNUSED(fmi3SetShiftFraction, (fmi3Instance i, REFERENCES, const uint64_t a[], const uint64_t b[]))
UNUSED(fmi3CompletedIntegratorStep, (fmi3Instance i, bool final, bool *event, bool *terminate))
UNUSED(fmi3SetTime, (fmi3Instance i, double time_s))
UNUSED(fmi3SetContinuousStates, (fmi3Instance i, const double x[], size_t n))
UNUSED(fmi3GetContinuousStateDerivatives, (fmi3Instance i, double x[], size_t n))
UNUSED(fmi3GetEventIndicators, (fmi3Instance i, double x[], size_t n))
UNUSED(fmi3GetContinuousStates, (fmi3Instance i, double x[], size_t n))
UNUSED(fmi3GetNominalsOfContinuousStates, (fmi3Instance i, double x[], size_t n))
UNUSED(fmi3GetNumberOfEventIndicators, (fmi3Instance i, size_t *n))
UNUSED(fmi3GetNumberOfContinuousStates, (fmi3Instance i, size_t *n))
UNUSED(fmi3ActivateModelPartition, (fmi3Instance i, fmi3ValueReference clock, double time_s))
