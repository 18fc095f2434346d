
/* The clamp cell: elastic between two bounds that are linear in functions of the signals. */
//%slot cell_tables

static void @_cell(@_state *s)
{
    double low = 0.0, high = 0.0, sum = 0.0, increment = 0.0, middle, half;
    double slid = s->memory_started ? s->slid : 0.0, unknown = 0.0;
    int j;
//%slot cell_bounds
    if (high < low) {
        low = 0.5 * (low + high);
        high = low;
    }
    middle = 0.5 * (low + high);
    half = 0.5 * (high - low);
//%if elastic
    if (s->memory_started) {
//%slot cell_increment
    }
//%end
    for (j = 0; j < //%here branch_count; j++) {
        const double lower = middle - @_width[j] * half, upper = middle + @_width[j] * half;
        const double trial =
            s->memory_started ? s->branches[j] + increment : lower + @_start * (upper - lower);
        /* A narrower branch reaches its bound first and does not determine the others. */
        if ((trial < lower || trial > upper) && @_width[j] > slid) {
            slid = @_width[j];
        }
        s->branches[j] = @_saturate(trial, lower, upper);
        sum += @_weight[j] * s->branches[j];
    }
    for (j = 0; j < //%here branch_count; j++) {
        if (@_width[j] > slid) {
            unknown += fabs(@_weight[j]) * @_width[j];
        }
    }
    s->slid = slid;
    s->known = slid >= 1.0;
    s->unknown = s->known ? 0.0 : unknown * (high - low);
    s->cell = sum;
    s->low = low;
    s->high = high;
}
