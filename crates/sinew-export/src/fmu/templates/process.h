/* The simulated plant runs in a process of the program `sinew`, which is found on PATH. One message a step
 * goes each way over a pair of sockets: numbers of 64 bits. A step below zero is an order about a state that
 * the process keeps, whose number stands in the place of the first input; 0 is the beginning. A state is
 * written as the number of messages from the beginning to it and these messages, and read by repeating them.
 */
#define @@_SAVE -2.0
#define @@_RESTORE -3.0
#define @@_DROP -4.0
#define @@_WRITE -5.0
#define @@_READ -6.0
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
    int phase;
    pid_t process;
} @_kept;

/* One message to the process: a step's length and the inputs. */
typedef struct {
    double step_s, inputs[@@_PORTS];
} @_message;

/* A state as bytes; the messages stand behind it. */
typedef struct {
    uint64_t checksum;
    double messages, time_s, inputs[@@_PORTS], said[@@_SAID];
    int phase, runs;
} @_packed;

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

/* Receives so many bytes; returns whether they came. */
static int @_receive(@_data *d, void *to, size_t size)
{
    char *const bytes = (char *)to;
    size_t done = 0;
    while (done < size) {
        const ssize_t got = recv(d->socket, bytes + done, size - done, 0);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            @_end(d);
            return 0;
        }
        done += got > 0 ? (size_t)got : 0u;
    }
    return 1;
}

/* Sends so many bytes; returns whether they went. */
static int @_send(@_data *d, const void *from, size_t size)
{
    const char *const bytes = (const char *)from;
    size_t done = 0;
    while (done < size) {
        const ssize_t sent = send(d->socket, bytes + done, size - done, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) {
            return 0;
        }
        done += sent > 0 ? (size_t)sent : 0u;
    }
    return 1;
}

/* What the plant says: whether it could step, then its outputs. */
static int @_listen(@_data *d)
{
    double said[1 + @@_SAID];
    if (!@_receive(d, said, sizeof said)) {
        return 0;
    }
    memcpy(d->said, said + 1, sizeof d->said);
    return !(said[0] > 0.0);
}

/* Starts the process; returns whether the plant is there. */
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
    return @_listen(d);
}

/* Asks for a step, or gives an order; returns whether it is done. */
static int @_ask(@_data *d, double step_s, const double *inputs)
{
    @_message asked;
    asked.step_s = step_s;
    memcpy(asked.inputs, inputs, sizeof asked.inputs);
    return @_send(d, &asked, sizeof asked) && @_listen(d);
}

/* An order about a state, which leaves what the plant said last; returns whether it is done. */
static int @_order(@_data *d, double order, double number)
{
    double inputs[@@_PORTS] = {0.0}, said[@@_SAID];
    int done;
    inputs[0] = number;
    memcpy(said, d->said, sizeof said);
    done = d->process > 0 && @_ask(d, order, inputs);
    memcpy(d->said, said, sizeof said);
    return done;
}

/* Steps to a time, or starts the plant there; returns whether it could. The step is not the difference of
 * two times, which is rounded. */
static int @_sample(@_data *d, double time_s, double step_s)
{
    static const double beginning[@@_PORTS] = {0.0};
    const int begins = d->phase != @@_STEPPING;
    int done = 0;
    if (d->process > 0) {
        done = @_ask(d, begins ? @@_RESTORE : step_s, begins ? beginning : d->inputs);
    } else if (begins) {
        done = @_launch(d);
    }
    if (done) {
        d->time_s = time_s;
    }
    return done;
}

/* An empty state of this instance. */
static @_kept *@_keep(@_data *d)
{
    @_kept *const kept = (@_kept *)calloc(1, sizeof *kept);
    if (kept != NULL) {
        d->saved += 1.0;
        kept->of = d;
        kept->number = d->saved;
    }
    return kept;
}

/* Whether a state is of this instance and of the process that it has now. */
static int @_is_ours(const @_data *d, const @_kept *kept)
{
    return kept != NULL && kept->of == d && (kept->process == 0 || kept->process == d->process);
}

/* Keeps the state, in room that is made where there is none; returns whether it could. */
static int @_copy(@_data *d, void **to)
{
    @_kept *const kept = *to == NULL ? @_keep(d) : (@_kept *)*to;
    if (kept == NULL) {
        return 0;
    }
    if (kept->of != d || (d->process > 0 && !@_order(d, @@_SAVE, kept->number))) {
        if (*to == NULL) {
            free(kept);
        }
        return 0;
    }
    kept->time_s = d->time_s;
    memcpy(kept->inputs, d->inputs, sizeof d->inputs);
    memcpy(kept->said, d->said, sizeof d->said);
    kept->phase = d->phase;
    kept->process = d->process;
    *to = kept;
    return 1;
}

/* Goes back to a state of this instance; returns whether it could. */
static int @_restore(@_data *d, const void *state)
{
    const @_kept *const kept = (const @_kept *)state;
    if (!@_is_ours(d, kept) || (kept->process > 0 && !@_order(d, @@_RESTORE, kept->number))) {
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
    if (@_is_ours(d, kept) && kept->process > 0) {
        (void)@_order(d, @@_DROP, kept->number);
    }
    free(state);
}

/* FNV-1a of the plant's token, then of what follows the checksum. */
static uint64_t @_checksum(const void *packed, size_t size)
{
    static const char token[] = "//%here token";
    const unsigned char *const bytes = (const unsigned char *)packed;
    uint64_t sum = 14695981039346656037u;
    size_t k;
    for (k = 0; k < sizeof token; k++) {
        sum = (sum ^ (unsigned char)token[k]) * 1099511628211u;
    }
    for (k = sizeof sum; k < size; k++) {
        sum = (sum ^ bytes[k]) * 1099511628211u;
    }
    return sum;
}

/* A state of this instance as bytes that the caller frees; none where it could not. */
static void *@_bytes(@_data *d, const void *state, size_t *size)
{
    const @_kept *const kept = (const @_kept *)state;
    @_packed *packed;
    double messages = 0.0;
    if (!@_is_ours(d, kept)
        || (kept->process > 0
            && !(@_order(d, @@_WRITE, kept->number) && @_receive(d, &messages, sizeof messages)))) {
        return NULL;
    }
    *size = sizeof *packed + (size_t)messages * sizeof(@_message);
    packed = (@_packed *)calloc(1, *size);
    if (packed == NULL) {
        /* Its messages would be taken for the next answer. */
        @_end(d);
        return NULL;
    }
    if (!@_receive(d, packed + 1, *size - sizeof *packed)) {
        free(packed);
        return NULL;
    }
    packed->messages = messages;
    packed->time_s = kept->time_s;
    memcpy(packed->inputs, kept->inputs, sizeof packed->inputs);
    memcpy(packed->said, kept->said, sizeof packed->said);
    packed->phase = kept->phase;
    packed->runs = kept->process > 0;
    packed->checksum = @_checksum(packed, *size);
    return packed;
}

/* Bytes that a state takes; returns whether they could be counted. */
static int @_size(@_data *d, const void *state, size_t *size)
{
    void *const bytes = @_bytes(d, state, size);
    free(bytes);
    return bytes != NULL;
}

/* Writes a state as bytes; returns whether it could. */
static int @_pack(@_data *d, const void *state, void *to, size_t room)
{
    size_t size = 0;
    void *const bytes = @_bytes(d, state, &size);
    const int fits = bytes != NULL && size <= room;
    if (fits) {
        memcpy(to, bytes, size);
    }
    free(bytes);
    return fits;
}

/* Has the process repeat messages and keep where they lead; returns whether it did. */
static int @_repeat(@_data *d, double number, double messages, const void *bytes, size_t size)
{
    @_message asked = {@@_READ, {0.0}};
    double said[@@_SAID];
    int done;
    asked.inputs[0] = number;
    memcpy(said, d->said, sizeof said);
    done = (d->process > 0 || @_launch(d)) && @_send(d, &asked, sizeof asked)
           && @_send(d, &messages, sizeof messages) && @_send(d, bytes, size) && @_listen(d);
    memcpy(d->said, said, sizeof said);
    return done;
}

/* The state that a unit of the same plant wrote as bytes, in room that is made where there is none; returns
 * whether it could. */
static int @_unpack(@_data *d, const void *bytes, size_t size, void **to)
{
    @_packed packed;
    @_kept *kept;
    if (bytes == NULL || size < sizeof packed) {
        return 0;
    }
    memcpy(&packed, bytes, sizeof packed);
    if (packed.checksum != @_checksum(bytes, size)) {
        return 0;
    }
    kept = *to == NULL ? @_keep(d) : (@_kept *)*to;
    if (kept == NULL) {
        return 0;
    }
    if (kept->of != d
        || (packed.runs && !@_repeat(d, kept->number, packed.messages, (const char *)bytes + sizeof packed,
                                     size - sizeof packed))) {
        if (*to == NULL) {
            free(kept);
        }
        return 0;
    }
    kept->time_s = packed.time_s;
    memcpy(kept->inputs, packed.inputs, sizeof kept->inputs);
    memcpy(kept->said, packed.said, sizeof kept->said);
    kept->phase = packed.phase;
    kept->process = packed.runs ? d->process : 0;
    *to = kept;
    return 1;
}
