/* Runs the predictor over a log: `./a.out LOG.csv` prints what `sinew predict` writes.
//%if inverse
 * Runs the compensator: `./a.out --inverse DESIRED.csv` prints what `sinew compensate` writes.
//%end
 *
 * The log is a table of numbers between commas, semicolons or tabs, with the names of its columns, as the
 * model has them, in the first line, with or without their units in brackets, in which they have to be;
 * where they are not separated by commas, decimals may be.
 * `./a.out LOG.csv HZ` counts the time of a log without a time column.
 */
#include "@.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COLUMNS (@@_INPUTS + 3) /* inputs, time, trial, far end */
#define CELL 256

//%slot columns

static char line[1 << 16];
static char separator = ',';
/* A cell that is neither a number nor missing. */
static char wrong[CELL];

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
    char text[CELL], *end, *comma;
    double value;
    strcpy(text, cell);
    comma = separator != ',' ? strchr(text, ',') : NULL;
    if (comma != NULL) {
        *comma = '.';
    }
    value = strtod(text, &end);
    if (end != text && *end == '\0') {
        return value;
    }
    if (text[0] != '\0' && strcmp(text, "NA") != 0 && strcmp(text, "N/A") != 0 && strcmp(text, "null") != 0) {
        strcpy(wrong, cell);
    }
    return NAN;
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

static void print_flags(unsigned flags, const char *const *names, unsigned count)
{
    const char *between = "";
    unsigned bit;
    for (bit = 0; bit < count; bit++) {
        if ((flags & (1u << bit)) != 0u) {
            printf("%s%s", between, names[bit]);
            between = "|";
        }
    }
}

/* Whether a name is that of a column, alone or with its unit in brackets. */
static int is_column(const char *cell, int column)
{
    const size_t length = strlen(columns[column]), unit = strlen(units[column]);
    if (length == 0 || strncmp(cell, columns[column], length) != 0) {
        return 0;
    }
    cell += length;
    cell += strspn(cell, " ");
    return *cell == '\0'
           || ((*cell == '(' || *cell == '[') && unit > 0 && strncmp(cell + 1, units[column], unit) == 0
               && (cell[unit + 1] == ')' || cell[unit + 1] == ']'));
}

/* Places of the columns in the header; returns whether the required ones are there. */
static int find_columns(int *places, const int *required)
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
            if (is_column(cell, column)) {
                places[column] = place;
            }
        }
    }
    for (column = 0; column < COLUMNS; column++) {
        if (required[column] && places[column] < 0) {
            fprintf(stderr, units[column][0] == '\0' ? "no column `%s` in the log\n"
                                                    : "no column `%s` in the log, or not in %s\n",
                    columns[column], units[column]);
            return 0;
        }
    }
    return 1;
}

/* One row of the log. */
typedef struct {
    double inputs[@@_INPUTS], time_s, desired;
    char trial[CELL];
} log_row;

/* The next row with its cells in their places; returns whether there is one. */
static int next_row(FILE *log, const int *places, log_row *row)
{
    char cell[CELL], *rest = line;
    int place, i;
    if (!next_line(log)) {
        return 0;
    }
    for (i = 0; i < @@_INPUTS; i++) {
        row->inputs[i] = NAN;
    }
    row->time_s = NAN;
    row->desired = NAN;
    row->trial[0] = '\0';
    for (place = 0; rest != NULL; place++) {
        rest = next_cell(rest, cell);
        for (i = 0; i < COLUMNS; i++) {
            if (places[i] != place) {
                continue;
            }
            if (i < @@_INPUTS) {
                row->inputs[i] = number(cell);
            } else if (i == @@_INPUTS) {
                row->time_s = number(cell) * //%here time_scale;
            } else if (i == @@_INPUTS + 1) {
                strcpy(row->trial, cell);
            } else {
                row->desired = number(cell);
            }
        }
    }
    return 1;
}

static void predict(const char *name, const log_row *row, int restarts)
{
    static const char *const flags[] = {"state_unknown", "out_of_range", "input_held", "reset",
                                        "other_specimen"};
    static @_state state;
    static int started;
    @_prediction p;
    if (!started) {
        @_init(&state);
        printf("log,trial,time_s,prediction,standard_deviation,gate,flags\n");
        started = 1;
    } else if (restarts) {
        @_reset(&state);
    }
    p = @_step(&state, row->time_s, row->inputs);
    printf("%s,%s,", name, row->trial);
    print_number(row->time_s);
    putchar(',');
    print_number(p.mean);
    putchar(',');
    print_number(p.standard_deviation);
    putchar(',');
    print_number(p.gate);
    putchar(',');
    print_flags(p.flags, flags, 5);
    putchar('\n');
}
//%if inverse

static void print_cell(double x)
{
    if (x == x) {
        print_number(x);
    }
    putchar(',');
}

static void command(const int *places, const log_row *row, int restarts)
{
    static const char *const flags[] = {"not_attainable", "rate_limited", "out_of_range",
                                        "correction_withdrawn", "state_unknown", "input_held", "reset",
                                        "repeated"};
    static @_compensator compensator;
    static int started;
    const int trial = places[@@_INPUTS + 1] >= 0;
    @_command u;
    int i;
    if (!started) {
        @_compensator_init(&compensator);
        if (trial) {
            printf("%s,", columns[@@_INPUTS + 1]);
        }
        printf("%s,", places[@@_INPUTS] >= 0 ? columns[@@_INPUTS] : "time_s");
        for (i = 0; i < @@_INPUTS; i++) {
            printf("%s,", columns[i]);
        }
        printf("%s,command_low,command_high,gate,flags\n", columns[@@_INPUTS + 2]);
        started = 1;
    } else if (restarts) {
        @_compensator_reset(&compensator);
    }
    u = @_compensator_step(&compensator, row->time_s, row->inputs, row->desired);
    if (trial) {
        printf("%s,", row->trial);
    }
//%if scaled
    print_cell(row->time_s * (places[@@_INPUTS] >= 0 ? //%here per_second : 1.0));
//%else
    print_cell(row->time_s);
//%end
    for (i = 0; i < @@_INPUTS; i++) {
        /* The row that belongs to the command. */
        print_cell(i == //%here near ? u.value : compensator.row[i]);
    }
    print_cell(row->desired);
    print_cell(u.low);
    print_cell(u.high);
    print_cell(u.gate);
    print_flags(u.flags, flags, 8);
    putchar('\n');
}
//%end

int main(int count, char **arguments)
{
//%if inverse
    const int inverse = count > 1 && strcmp(arguments[1], "--inverse") == 0;
//%else
    const int inverse = 0;
//%end
    const char *const path = count > 1 + inverse ? arguments[1 + inverse] : NULL;
    const char *const rate = count > 2 + inverse ? arguments[2 + inverse] : NULL;
    const double rate_hz = rate != NULL ? strtod(rate, NULL) : 0.0;
    int places[COLUMNS], required[COLUMNS], started = 0, i;
    char trial[CELL] = "";
    double last_s = 0.0;
    long rows = 0;
    log_row row;
    long index;
    const char *name;
    FILE *log;
    if (path == NULL || (rate != NULL && !(rate_hz > 0.0))) {
//%if inverse
        fprintf(stderr, "usage: %s [--inverse] LOG.csv [HZ]\n", arguments[0]);
//%else
        fprintf(stderr, "usage: %s LOG.csv [HZ]\n", arguments[0]);
//%end
        return 2;
    }
    log = fopen(path, "r");
    if (log == NULL) {
        perror(path);
        return 2;
    }
    for (i = 0; i < COLUMNS; i++) {
        required[i] = i < @@_INPUTS || (i == @@_INPUTS && rate == NULL);
    }
//%if inverse
    if (inverse) {
        required[@@_INPUTS + 2] = 1;
//%slot optional
    }
//%end
    if (!next_line(log) || !find_columns(places, required)) {
        fclose(log);
        return 2;
    }
    name = strrchr(path, '/');
    name = name == NULL ? path : name + 1;
    for (index = 0; next_row(log, places, &row); index++) {
        if (wrong[0] != '\0') {
            fprintf(stderr, "%s, row %ld: expected a number in the model's unit, found `%s`\n", path, index + 1,
                    wrong);
            fclose(log);
            return 2;
        }
        if (rate != NULL) {
            row.time_s = (double)index * (1.0 / rate_hz);
        }
        if (started && strcmp(trial, row.trial) != 0) {
            started = 0;
        }
        strcpy(trial, row.trial);
        /* Rows without a time, and those that repeat one, are left out. */
        if (!(row.time_s - row.time_s == 0.0) || (started && !(row.time_s > last_s))) {
            continue;
        }
//%if inverse
        if (inverse) {
            command(places, &row, !started);
        } else {
            predict(name, &row, !started);
        }
//%else
        predict(name, &row, !started);
//%end
        started = 1;
        last_s = row.time_s;
        rows++;
    }
    fclose(log);
    if (rows == 0) {
        fprintf(stderr, "%s: no row with a number for its time\n", path);
        return 2;
    }
    return 0;
}
