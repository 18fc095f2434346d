/* The simulated plant runs in a process of the program `sinew`, which is found on PATH. One message a step
 * goes each way over a pair of sockets: numbers of 64 bits. A step below zero is an order about a state that
 * the process keeps, whose number stands in the place of the first input; 0 is the beginning.
 */
#define @@_SAVE -2.0
#define @@_RESTORE -3.0
#define @@_DROP -4.0
#define @@_SAID (//%here numbers + @@_FLAGS)
#ifndef MSG_NOSIGNAL
#define MSG_NOSIGNAL 0
#endif

typedef struct {
    double time_s;
    double inputs[@@_PORTS];
    double said[@@_SAID];
    /* Of the file with the plant. */
    char *path;
    /* Number of the state that was saved last. */
    double saved;
    int phase, socket;
    pid_t process;
} @_data;

/* A state: what is the unit's, and the number of what the process keeps, if it runs. */
typedef struct {
    const @_data *of;
    double number, time_s, inputs[@@_PORTS], said[@@_SAID];
    int phase, runs;
} @_kept;

/* Ends the process: it stops where nobody talks to it. */
static void @_end(@_data *d)
{
    if (d->process > 0) {
        close(d->socket);
        while (waitpid(d->process, NULL, 0) < 0 && errno == EINTR) {
        }
    }
    d->process = 0;
}

static void @_start(@_data *d)
{
    static const double start[@@_PORTS] = {//%here starts};
    memcpy(d->inputs, start, sizeof start);
    memset(d->said, 0, sizeof d->said);
    d->time_s = 0.0;
    d->phase = @@_INSTANTIATED;
}

static int @_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Keeps the path of the plant's file in a folder, which FMI 2.0 gives as a URI; returns whether it could. */
static int @_find(@_data *d, const char *resources)
{
    static const char file[] = "/plant.json";
    int uri;
    char *to;
    if (resources == NULL) {
        return 0;
    }
    uri = strncmp(resources, "file:", 5) == 0;
    resources += !uri ? 0 : strncmp(resources, "file://", 7) == 0 ? 7 : 5;
    d->path = (char *)malloc(strlen(resources) + sizeof file);
    if (d->path == NULL) {
        return 0;
    }
    for (to = d->path; *resources != '\0'; to++, resources++) {
        const int high = uri && *resources == '%' ? @_digit(resources[1]) : -1;
        const int low = high >= 0 ? @_digit(resources[2]) : -1;
        *to = low >= 0 ? (char)(high * 16 + low) : *resources;
        resources += low >= 0 ? 2 : 0;
    }
    memcpy(to, file, sizeof file);
    return 1;
}

static int @_launch(@_data *d)
{
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) {
        return 0;
    }
    /* Processes of other instances do not hold them open. */
    fcntl(ends[0], F_SETFD, FD_CLOEXEC);
    fcntl(ends[1], F_SETFD, FD_CLOEXEC);
    d->process = fork();
    if (d->process == 0) {
        if (dup2(ends[1], 0) == 0 && dup2(ends[1], 1) == 1) {
            execlp("sinew", "sinew", "export", "serve", d->path, (char *)NULL);
        }
        _exit(127);
    }
    close(ends[1]);
    if (d->process < 0) {
        close(ends[0]);
        return 0;
    }
    d->socket = ends[0];
    return 1;
}

/* What the plant says: whether it could step, then its outputs. */
static int @_listen(@_data *d)
{
    double said[1 + @@_SAID];
    char *const bytes = (char *)said;
    size_t done = 0;
    while (done < sizeof said) {
        const ssize_t got = recv(d->socket, bytes + done, sizeof said - done, 0);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            @_end(d);
            return 0;
        }
        done += got > 0 ? (size_t)got : 0u;
    }
    memcpy(d->said, said + 1, sizeof d->said);
    return !(said[0] > 0.0);
}

/* Asks for a step, or gives an order; returns whether it is done. */
static int @_ask(@_data *d, double step_s, const double *inputs)
{
    double asked[1 + @@_PORTS];
    const char *const bytes = (const char *)asked;
    size_t done = 0;
    asked[0] = step_s;
    memcpy(asked + 1, inputs, sizeof d->inputs);
    while (done < sizeof asked) {
        const ssize_t sent = send(d->socket, bytes + done, sizeof asked - done, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) {
            return 0;
        }
        done += sent > 0 ? (size_t)sent : 0u;
    }
    return @_listen(d);
}

static int @_order(@_data *d, double order, double number)
{
    double inputs[@@_PORTS];
    memcpy(inputs, d->inputs, sizeof inputs);
    inputs[0] = number;
    return d->process > 0 && @_ask(d, order, inputs);
}

/* Steps to a time, or starts the plant there; returns whether it could. The step is not the difference of
 * two times, which is rounded. */
static int @_sample(@_data *d, double time_s, double step_s)
{
    const int begins = d->phase != @@_STEPPING;
    int done = 0;
    if (d->process > 0) {
        done = begins ? @_order(d, @@_RESTORE, 0.0) : @_ask(d, step_s, d->inputs);
    } else if (begins) {
        done = @_launch(d) && @_listen(d);
    }
    if (done) {
        d->time_s = time_s;
    }
    return done;
}

/* Keeps the state, in room that is made where there is none; returns whether it could. */
static int @_copy(@_data *d, void **to)
{
    @_kept *kept = (@_kept *)*to;
    if (kept == NULL) {
        kept = (@_kept *)malloc(sizeof *kept);
        if (kept == NULL) {
            return 0;
        }
        d->saved += 1.0;
        kept->of = d;
        kept->number = d->saved;
    }
    kept->runs = d->process > 0;
    if (kept->of != d || (kept->runs && !@_order(d, @@_SAVE, kept->number))) {
        if (*to == NULL) {
            free(kept);
        }
        return 0;
    }
    kept->time_s = d->time_s;
    memcpy(kept->inputs, d->inputs, sizeof d->inputs);
    memcpy(kept->said, d->said, sizeof d->said);
    kept->phase = d->phase;
    *to = kept;
    return 1;
}

/* Goes back to a state of this instance; returns whether it could. */
static int @_restore(@_data *d, const void *state, size_t size)
{
    const @_kept *const kept = (const @_kept *)state;
    (void)size;
    if (kept == NULL || kept->of != d || (kept->runs && !@_order(d, @@_RESTORE, kept->number))) {
        return 0;
    }
    d->time_s = kept->time_s;
    memcpy(d->inputs, kept->inputs, sizeof d->inputs);
    memcpy(d->said, kept->said, sizeof d->said);
    d->phase = kept->phase;
    return 1;
}

static void @_forget(@_data *d, void *state)
{
    const @_kept *const kept = (const @_kept *)state;
    if (kept != NULL && kept->of == d && kept->runs) {
        (void)@_order(d, @@_DROP, kept->number);
    }
    free(state);
}
