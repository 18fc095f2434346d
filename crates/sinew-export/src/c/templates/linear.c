
/* Linear regression on the features. */
//%slot linear_tables

static double @_linear(const double *x)
{
    double sum = @_linear_offset;
    int i;
    for (i = 0; i < //%here feature_count; i++) {
        sum += @_linear_weights[i] * x[i];
    }
    return sum;
}
