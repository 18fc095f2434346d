/* S-function of the predictor. In MATLAB, in this folder: mex sfunction_@.c ../@.c
 *
 * Input: a vector of the //%here input_count inputs of ../@.h. Output: prediction, standard deviation,
 * gate, flags. Parameter: the sample time, s.
 */
#define S_FUNCTION_NAME sfunction_@
#define S_FUNCTION_LEVEL 2

#include "../@.h"
#include "simstruc.h"

static void mdlInitializeSizes(SimStruct *S)
{
    ssSetNumSFcnParams(S, 1);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) {
        return;
    }
    if (!ssSetNumInputPorts(S, 1) || !ssSetNumOutputPorts(S, 1)) {
        return;
    }
    ssSetInputPortWidth(S, 0, @@_INPUTS);
    ssSetInputPortDirectFeedThrough(S, 0, 1);
    ssSetInputPortRequiredContiguous(S, 0, 1);
    ssSetOutputPortWidth(S, 0, 4);
    ssSetNumSampleTimes(S, 1);
    ssSetNumDWork(S, 1);
    ssSetDWorkWidth(S, 0, (int_T)sizeof(@_state));
    ssSetDWorkDataType(S, 0, SS_UINT8);
    ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE);
}

static void mdlInitializeSampleTimes(SimStruct *S)
{
    ssSetSampleTime(S, 0, mxGetScalar(ssGetSFcnParam(S, 0)));
    ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S)
{
    @_init((@_state *)ssGetDWork(S, 0));
}

static void mdlOutputs(SimStruct *S, int_T tid)
{
    const real_T *const inputs = ssGetInputPortRealSignal(S, 0);
    real_T *const outputs = ssGetOutputPortRealSignal(S, 0);
    const @_prediction p = @_step((@_state *)ssGetDWork(S, 0), ssGetT(S), inputs);
    (void)tid;
    outputs[0] = p.mean;
    outputs[1] = p.standard_deviation;
    outputs[2] = p.gate;
    outputs[3] = (real_T)p.flags;
}

static void mdlTerminate(SimStruct *S)
{
    (void)S;
}

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
