/* Runs the predictor over a log: `./a.out LOG.csv` prints what `sinew predict` writes.
 *
 * The log is a table of numbers between commas, semicolons or tabs, with the names of its columns in the
 * first line. `./a.out LOG.csv HZ` counts the time of a log without a time column.
 */
#include "@.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS (@@_INPUTS + 2) /* inputs, time, trial */
#define CELL 256

//%slot columns

static char line[1 << 16];
static char separator = ',';

/* The next cell of a line, without blanks and quotes; returns what follows it, or a null pointer at the
 * end. */
static char *next_cell(char *text, char *cell)
{
    size_t length = 0;
    int quoted = 0;
    for (; *text != '\0' && (quoted || *text != separator); text++) {
        if (*text == '"') {
            quoted = !quoted;
        } else if (length + 1 < CELL && (length > 0 || !isspace((unsigned char)*text))) {
            cell[length++] = *text;
        }
    }
    while (length > 0 && isspace((unsigned char)cell[length - 1])) {
        length--;
    }
    cell[length] = '\0';
    return *text == separator ? text + 1 : NULL;
}

/* A line that is neither empty nor a comment. */
static int next_line(FILE *log)
{
    while (fgets(line, sizeof line, log) != NULL) {
        const size_t begin = strspn(line, " \t\r\n");
        line[strcspn(line, "\r\n")] = '\0';
        if (line[begin] != '\0' && line[begin] != '#') {
            return 1;
        }
    }
    return 0;
}

static double number(const char *cell)
{
    char *end;
    const double value = strtod(cell, &end);
    return end == cell || *end != '\0' ? NAN : value;
}

/* The shortest decimal number that gives the same bits, the upper one of two that are as near, without an
 * exponent. */
static void print_number(double x)
{
    char text[64], exact[128], digits[32];
    int count, exponent, k;
    if (x == 0.0 || x - x != 0.0) {
        printf(x == 0.0 ? (signbit(x) ? "-0" : "0") : x != x ? "NaN" : x > 0.0 ? "inf" : "-inf");
        return;
    }
    if (x < 0.0) {
        putchar('-');
        x = -x;
    }
    for (count = 1; count < 18; count++) {
        sprintf(text, "%.*e", count - 1, x);
        if (strtod(text, NULL) == x) {
            break;
        }
    }
    /* "d.ddde+xx": where the rest of the exact digits is a half, printf has rounded to the even one. */
    sprintf(exact, "%.70e", x);
    k = count == 1 ? 0 : count;
    if (exact[k] == text[k] && exact[count + 1] == '5'
        && strspn(exact + count + 2, "0") == (size_t)(70 - count)) {
        text[k]++;
    }
    exponent = (int)strtol(strchr(text, 'e') + 1, NULL, 10);
    digits[0] = text[0];
    memcpy(digits + 1, text + 2, (size_t)(count - 1));
    if (exponent < 0) {
        printf("0.");
        for (k = exponent + 1; k < 0; k++) {
            putchar('0');
        }
    }
    for (k = 0; k < count || k <= exponent; k++) {
        putchar(k < count ? digits[k] : '0');
        if (k == exponent && k + 1 < count) {
            putchar('.');
        }
    }
}

static void print_flags(unsigned flags)
{
    static const char *const names[] = {"state_unknown", "out_of_range", "input_held", "reset"};
    const char *between = "";
    unsigned bit;
    for (bit = 0; bit < 4; bit++) {
        if ((flags & (1u << bit)) != 0u) {
            printf("%s%s", between, names[bit]);
            between = "|";
        }
    }
}

/* Places of the columns in the header; returns whether all inputs and the time are there. */
static int find_columns(int *places, int counted)
{
    static const char separators[] = ";\t";
    char cell[CELL], *rest = line;
    int place = 0, column, k;
    /* A byte order mark is no part of the first name. */
    if (strncmp(line, "\357\273\277", 3) == 0) {
        rest = line + 3;
    }
    for (k = 0; k < 2; k++) {
        if (strchr(line, separators[k]) != NULL) {
            separator = separators[k];
        }
    }
    for (column = 0; column < COLUMNS; column++) {
        places[column] = -1;
    }
    for (; rest != NULL; place++) {
        rest = next_cell(rest, cell);
        for (column = 0; column < COLUMNS; column++) {
            if (columns[column][0] != '\0' && strcmp(cell, columns[column]) == 0) {
                places[column] = place;
            }
        }
    }
    for (column = 0; column < @@_INPUTS + (counted ? 0 : 1); column++) {
        if (places[column] < 0) {
            fprintf(stderr, "no column `%s` in the log\n", columns[column]);
            return 0;
        }
    }
    return 1;
}

int main(int count, char **arguments)
{
    static @_state state;
    double inputs[@@_INPUTS], last_s = 0.0;
    const double rate_hz = count > 2 ? strtod(arguments[2], NULL) : 0.0;
    char cell[CELL], trial[CELL] = "", new_trial[CELL];
    int places[COLUMNS], started = 0;
    long row;
    const char *name;
    FILE *log;
    if (count < 2 || (count > 2 && !(rate_hz > 0.0))) {
        fprintf(stderr, "usage: %s LOG.csv [HZ]\n", arguments[0]);
        return 2;
    }
    log = fopen(arguments[1], "r");
    if (log == NULL) {
        perror(arguments[1]);
        return 2;
    }
    if (!next_line(log) || !find_columns(places, count > 2)) {
        fclose(log);
        return 2;
    }
    name = strrchr(arguments[1], '/');
    name = name == NULL ? arguments[1] : name + 1;
    @_init(&state);
    printf("log,trial,time_s,prediction,standard_deviation,gate,flags\n");
    for (row = 0; next_line(log); row++) {
        char *rest = line;
        double time_s = NAN;
        int place, i;
        @_prediction p;
        for (i = 0; i < @@_INPUTS; i++) {
            inputs[i] = NAN;
        }
        new_trial[0] = '\0';
        for (place = 0; rest != NULL; place++) {
            rest = next_cell(rest, cell);
            for (i = 0; i < COLUMNS; i++) {
                if (places[i] != place) {
                    continue;
                }
                if (i < @@_INPUTS) {
                    inputs[i] = number(cell);
                } else if (i == @@_INPUTS) {
                    time_s = number(cell) * //%here time_scale;
                } else {
                    strcpy(new_trial, cell);
                }
            }
        }
        if (count > 2) {
            time_s = (double)row * (1.0 / rate_hz);
        }
        if (started && strcmp(trial, new_trial) != 0) {
            @_reset(&state);
            started = 0;
        }
        strcpy(trial, new_trial);
        /* Rows without a time, and those that repeat one, are left out. */
        if (!(time_s - time_s == 0.0) || (started && !(time_s > last_s))) {
            continue;
        }
        p = @_step(&state, time_s, inputs);
        started = 1;
        last_s = time_s;
        printf("%s,%s,", name, trial);
        print_number(time_s);
        putchar(',');
        print_number(p.mean);
        putchar(',');
        print_number(p.standard_deviation);
        putchar(',');
        print_number(p.gate);
        putchar(',');
        print_flags(p.flags);
        putchar('\n');
    }
    fclose(log);
    return 0;
}
