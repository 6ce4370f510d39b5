#include "tools/console.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The program has one terminal, so this is one object. */
static struct {
    bool quiet, no_progress, terminal;
    bool bar_open;
    char stage[48];
    double printed; /* when the stage was last shown, and what of it was done */
    double shown;
    /* Two moments to measure the speed from: what an earlier run did is there at once and
     * must not count, so the older one is left behind after a while. */
    struct {
        double time, done;
    } from, next;
} console;

double tool_seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void tool_console_clear(void)
{
    if (!console.bar_open) return;
    (void)fprintf(stderr, "\r\033[K");
    (void)fflush(stderr);
    console.bar_open = false;
}

static void warn(void *user, const char *sentence)
{
    (void)user;
    if (console.quiet) return;
    tool_console_clear();
    (void)fprintf(stderr, "pbnds: warning: %s\n", sentence);
}

enum { SPEED_SECONDS = 20 };

/* "3 min 20 s left, 2.1 a second": the speed where single units mean something. */
static void format_left(char *text, size_t size, double now, double done, double total)
{
    static const char *const COUNTED[] = {"dataset", "train", "import"};
    const double speed = (done - console.from.done) / (now - console.from.time);
    text[0] = 0;
    if (!(speed > 0.0) || !(total > 0.0)) return;
    const double left = (total - done) / speed;
    int used;
    if (left >= 3600.0) {
        used = snprintf(text, size, "%ld h %02ld min left", (long)(left / 3600.0),
                        (long)(left / 60.0) % 60);
    } else if (left >= 60.0) {
        used = snprintf(text, size, "%d min %02d s left", (int)(left / 60.0),
                        (int)left % 60);
    } else {
        used = snprintf(text, size, "%.0f s left", left);
    }
    for (size_t i = 0; i < sizeof COUNTED / sizeof COUNTED[0]; ++i) {
        if (strcmp(console.stage, COUNTED[i]) == 0)
            (void)snprintf(text + used, size - (size_t)used, ", %.3g a second", speed);
    }
}

static void draw_bar(double fraction, const char *left)
{
    static const char full[] = "##############################";
    enum { WIDTH = sizeof full - 1 };
    const int n = (int)(fraction * WIDTH);
    (void)fprintf(stderr, "\r\033[K%-12s [%.*s%*s] %3.0f %%  %s", console.stage, n,
                  full, WIDTH - n, "", 100.0 * fraction, left);
    (void)fflush(stderr);
    console.bar_open = true;
}

static void begin_stage(const char *stage, double now, double done)
{
    tool_console_clear();
    (void)snprintf(console.stage, sizeof console.stage, "%s", stage);
    console.printed = now;
    console.shown = 0.0;
    console.from.time = console.next.time = now;
    console.from.done = console.next.done = done;
}

/* On a terminal a bar, ten times a second; elsewhere a line at most once a second and
 * only when another tenth is done, so that short runs say nothing. */
static void progress(void *user, const char *stage, double done, double total)
{
    (void)user;
    if (console.quiet || console.no_progress) return;
    const double now = tool_seconds();
    if (strncmp(stage, console.stage, sizeof console.stage - 1) != 0)
        begin_stage(stage, now, done);
    if (now - console.next.time > SPEED_SECONDS) {
        console.from = console.next;
        console.next.time = now;
        console.next.done = done;
    }
    double fraction = total > 0.0 ? done / total : 0.0;
    if (fraction > 1.0) fraction = 1.0;
    if (fraction >= 1.0) { /* the next of the same name starts anew */
        tool_console_clear();
        console.stage[0] = 0;
        return;
    }
    char left[80];
    format_left(left, sizeof left, now, done, total);
    if (console.terminal) {
        if (now - console.printed < 0.1) return;
        draw_bar(fraction, left);
    } else {
        const bool another = total > 0.0 ? fraction >= console.shown + 0.1 : true;
        if (now - console.printed < 1.0 || !another) return;
        if (total > 0.0) {
            (void)fprintf(stderr, "pbnds: %s %d %%, %s\n", stage,
                          (int)(100.0 * fraction), left);
        } else {
            (void)fprintf(stderr, "pbnds: %s %.0f\n", stage, done);
        }
    }
    console.printed = now;
    console.shown = fraction;
}

static const struct pbnds_report report = {warn, progress, NULL};

const struct pbnds_report *tool_report(void)
{
    return &report;
}

void tool_console_quiet(bool quiet)
{
    console.quiet = quiet;
}

void tool_console_no_progress(void)
{
    console.no_progress = true;
}

enum pbnds_status tool_check_stop(struct pbnds_error *error)
{
    return pbnds_stop_requested() ? pbnds_fail_interrupted(error) : PBNDS_OK;
}

static void on_signal(int number)
{
    (void)number;
    pbnds_request_stop();
}

void tool_console_init(void)
{
    struct sigaction action = {.sa_handler = on_signal};
    (void)sigemptyset(&action.sa_mask);
    /* SA_RESETHAND: a second Ctrl-C meets the default action and kills at once. */
    action.sa_flags = SA_RESTART | (int)SA_RESETHAND;
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    action.sa_handler = SIG_IGN;
    action.sa_flags = 0;
    (void)sigaction(SIGPIPE, &action, NULL);
    (void)sigaction(SIGXFSZ, &action, NULL);
    console.terminal = isatty(STDERR_FILENO) != 0;
}
