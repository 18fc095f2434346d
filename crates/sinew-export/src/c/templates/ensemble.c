
/* Eight networks with one hidden layer: clip box, scaling, weights. */
//%slot ensemble_tables

/* Loops over the networks are vectorised; compilers that unroll them first make them several times slower. */
#if defined(__clang__)
#define @@_TOGETHER _Pragma("clang loop unroll(disable)")
#elif defined(__GNUC__) && __GNUC__ >= 8
#define @@_TOGETHER _Pragma("GCC unroll 1")
#else
#define @@_TOGETHER
#endif

static void @_order(float *v, int i, int j)
{
    const float a = v[i], b = v[j];
    v[i] = a < b ? a : b;
    v[j] = a > b ? a : b;
}

static float @_sum(const float *v)
{
    return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

/* Median and variance of the networks; returns the number of features outside the clip box. */
static int @_ensemble(//%here feature_argument double *median, double *variance,
                     double *beyond)
{
//%if features
    float z[//%here feature_count];
    int f;
//%end
    float outputs[8], squares[8], average;
    int clipped = 0, k;
//%if nodes
    int node;
//%end
    *beyond = 0.0;
//%if features
    for (f = 0; f < //%here feature_count; f++) {
        const double x = features[f];
        const double above = x < @_clip_low[f] ? @_clip_low[f] : x;
        const double inside = above > @_clip_high[f] ? @_clip_high[f] : above;
        const double excess = @_magnitude(x - inside) * @_inverse_scale[f];
        clipped += (x < @_clip_low[f]) + (x > @_clip_high[f]);
        *beyond = @_larger(*beyond, excess);
        z[f] = (float)((inside - @_mean[f]) * @_inverse_scale[f]);
    }
//%end
    @@_TOGETHER for (k = 0; k < 8; k++) {
        outputs[k] = @_bias[k];
    }
//%if features
    for (f = 0; f < //%here feature_count; f++) {
        @@_TOGETHER for (k = 0; k < 8; k++) {
            outputs[k] += @_skip[f][k] * z[f];
        }
    }
//%end
//%if nodes
    for (node = 0; node < //%here node_count; node++) {
        float sums[8];
        @@_TOGETHER for (k = 0; k < 8; k++) {
            sums[k] = @_hidden_bias[node][k];
        }
        for (f = 0; f < //%here feature_count; f++) {
            @@_TOGETHER for (k = 0; k < 8; k++) {
                sums[k] += @_hidden[node][f][k] * z[f];
            }
        }
        @@_TOGETHER for (k = 0; k < 8; k++) {
            const float edge = //%here quick_edge;
            const float x = sums[k] < -edge ? -edge : sums[k] > edge ? edge : sums[k];
            const float square = x * x;
            const float p = 135135.0f + square * (17325.0f + square * (378.0f + square));
            const float q = 135135.0f + square * (62370.0f + square * (3150.0f + square * 28.0f));
            outputs[k] += @_output[node][k] * (x * p / q);
        }
    }
//%end
    average = @_sum(outputs) / 8.0f;
    @@_TOGETHER for (k = 0; k < 8; k++) {
        const float deviation = outputs[k] - average;
        squares[k] = deviation * deviation;
    }
    *variance = (double)(@_sum(squares) / 7.0f);
    @_order(outputs, 0, 1);
    @_order(outputs, 2, 3);
    @_order(outputs, 4, 5);
    @_order(outputs, 6, 7);
    @_order(outputs, 0, 2);
    @_order(outputs, 1, 3);
    @_order(outputs, 4, 6);
    @_order(outputs, 5, 7);
    @_order(outputs, 1, 2);
    @_order(outputs, 5, 6);
    @_order(outputs, 0, 4);
    @_order(outputs, 1, 5);
    @_order(outputs, 2, 6);
    @_order(outputs, 3, 7);
    @_order(outputs, 2, 4);
    @_order(outputs, 3, 5);
    @_order(outputs, 3, 4);
    *median = (double)(0.5f * (outputs[3] + outputs[4]));
    return clipped;
}
