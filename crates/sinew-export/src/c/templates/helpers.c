//%if larger
static double @_larger(double a, double b)
{
    return b > a ? b : a;
}

//%end
//%if smaller
static double @_smaller(double a, double b)
{
    return b < a ? b : a;
}

//%end
//%if magnitude
static double @_magnitude(double x)
{
    return x < 0.0 ? -x : x;
}
//%end
//%if saturate

static double @_saturate(double value, double low, double high)
{
    return @_smaller(@_larger(value, low), high);
}
//%end
//%if sign

static double @_with_sign_of(double magnitude, double sign)
{
    return sign < 0.0 ? -magnitude : magnitude;
}
//%end
//%if bits

typedef union {
    double number;
    uint64_t bits;
} @_double;
//%end
//%if log

/* Natural logarithm of a number above zero; FreeBSD's e_log.c, Copyright (C) 1993 by Sun Microsystems, Inc.
 * Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice
 * is preserved. */
static double @_log(double x)
{
    @_double u;
    uint32_t high;
    int k = 0;
    double f, half_square, s, z, w, t1, t2, dk;
    u.number = x;
    high = (uint32_t)(u.bits >> 32);
    if (high == 0x3ff00000u && (u.bits << 32) == 0) {
        return 0.0;
    }
    high += 0x3ff00000u - 0x3fe6a09eu;
    k += (int)(high >> 20) - 0x3ff;
    high = (high & 0x000fffffu) + 0x3fe6a09eu;
    u.bits = ((uint64_t)high << 32) | (u.bits & 0xffffffffu);
    f = u.number - 1.0;
    half_square = 0.5 * f * f;
    s = f / (2.0 + f);
    z = s * s;
    w = z * z;
    t1 = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    t2 = z * (6.666666666666735130e-01
              + w * (2.857142874366239149e-01
                     + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    dk = (double)k;
    return s * (half_square + (t2 + t1)) + dk * 1.90821492927058770002e-10 - half_square + f
           + dk * 6.93147180369123816490e-01;
}
//%end
//%if gaussian

/* Exponential of a number not above zero; FreeBSD's e_exp.c, Copyright (C) 2004 by Sun Microsystems, Inc.
 * Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice
 * is preserved. */
static double @_exp(double x)
{
    @_double u;
    uint32_t high;
    int k;
    double upper, lower, xx, c, y;
    u.number = x;
    high = (uint32_t)(u.bits >> 32) & 0x7fffffffu;
    if (high >= 0x4086232bu && x < -745.13321910194110842) {
        return 0.0;
    }
    if (high > 0x3fd62e42u) {
        k = high >= 0x3ff0a2b2u ? (int)(1.44269504088896338700e+00 * x - 0.5) : -1;
        upper = x - (double)k * 6.93147180369123816490e-01;
        lower = (double)k * 1.90821492927058770002e-10;
        x = upper - lower;
    } else if (high > 0x3e300000u) {
        k = 0;
        upper = x;
        lower = 0.0;
    } else {
        return 1.0 + x;
    }
    xx = x * x;
    c = x - xx * (1.66666666666666019037e-01
                  + xx * (-2.77777777770155933842e-03
                          + xx * (6.61375632143793436117e-05
                                  + xx * (-1.65339022054652515390e-06 + xx * 4.13813679705723846039e-08))));
    y = 1.0 + (x * c / (2.0 - c) - lower + upper);
    if (k < -1022) {
        /* First towards the smallest numbers, then below them: rounded once. */
        y *= 0x1p-969;
        k += 969;
        if (k < -1022) {
            y *= 0x1p-969;
            k += 969;
            if (k < -1022) {
                k = -1022;
            }
        }
    }
    u.bits = (uint64_t)(1023 + k) << 52;
    return y * u.number;
}
//%end
