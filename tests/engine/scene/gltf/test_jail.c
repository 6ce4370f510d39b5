/* What a scene file may open: every way out that we know of is tried. */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/scene/gltf/jail.h"
#include "tests/engine/scene/gltf/fixture.h"

#define ROOT "jail-root"
#define CELL ROOT "/cell"

static void put(const char *path, const char *text)
{
    assert_int_equal(pbnds_file_write(path, text, strlen(text), &fault), PBNDS_OK);
}

static void link_to(const char *target, const char *path)
{
    (void)unlink(path);
    assert_int_equal(symlink(target, path), 0);
}

/** "in" or "out", what the file that opened says; "" where none did. */
static const char *what_opens(const char *path, bool external, enum pbnds_jail *jail)
{
    static char text[8];
    int fd = -1;
    memset(text, 0, sizeof text);
    *jail = pbnds_jail_open(CELL, path, strlen(path), external, &fd);
    assert_int_equal(*jail == PBNDS_JAIL_OPEN, fd >= 0);
    if (fd >= 0) {
        assert_true(read(fd, text, 3) >= 0);
        (void)close(fd);
    }
    return text;
}

static int build(void **state)
{
    (void)state;
    char here[600], target[700];
    assert_int_equal(pbnds_make_folder(CELL "/deep/er", &fault), PBNDS_OK);
    assert_int_equal(pbnds_make_folder(ROOT "/cell2", &fault), PBNDS_OK);
    put(CELL "/a.bin", "in");
    put(CELL "/deep/er/a.bin", "in");
    put(CELL "/a%2fb", "in");
    put(ROOT "/out.bin", "out");
    put(ROOT "/cell2/out.bin", "out"); /* the folder's name is a prefix of this one */
    assert_non_null(getcwd(here, sizeof here));
    (void)snprintf(target, sizeof target, "%s/" ROOT "/out.bin", here);
    link_to(target, CELL "/absolute");
    (void)snprintf(target, sizeof target, "%s/" CELL "/a.bin", here);
    link_to(target, CELL "/absolute-in");
    link_to("../out.bin", CELL "/file-out");
    link_to("..", CELL "/folder-out");
    link_to("file-out", CELL "/link-to-link");
    link_to("../../a.bin", CELL "/deep/er/up-in");
    link_to("../../../out.bin", CELL "/deep/er/up-out");
    link_to("../cell/a.bin", CELL "/out-and-in");
    link_to("deep", CELL "/folder-in");
    link_to("loop", CELL "/loop");
    link_to("/dev/zero", CELL "/zero");
    (void)unlink(CELL "/pipe");
    assert_int_equal(mkfifo(CELL "/pipe", 0600), 0);
    (void)unlink(CELL "/socket");
    struct sockaddr_un name = {.sun_family = AF_UNIX, .sun_path = CELL "/socket"};
    const int s = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_true(s >= 0);
    assert_int_equal(bind(s, (const struct sockaddr *)&name, sizeof name), 0);
    (void)close(s);
    return 0;
}

struct attempt {
    const char *path;
    int closed, external; /* enum pbnds_jail, without and with --allow-external */
};

static void every_way_out_is_closed(void **state)
{
    (void)state;
    enum { OPEN = PBNDS_JAIL_OPEN, OUTSIDE = PBNDS_JAIL_OUTSIDE };
    enum { MISSING = PBNDS_JAIL_MISSING, SPECIAL = PBNDS_JAIL_SPECIAL };
    enum { SCHEME = PBNDS_JAIL_SCHEME };
    static const struct attempt attempts[] = {
        {"a.bin", OPEN, OPEN},
        {"./deep//er/a.bin", OPEN, OPEN},
        {"deep/er/up-in", OPEN, OPEN}, /* .. inside a link, which stays inside */
        {"folder-in/er/a.bin", OPEN, OPEN},
        {"absolute-in", OPEN, OPEN},
        {"out-and-in", OPEN, OPEN},
        {"a%2fb", OPEN, OPEN}, /* decoded once already: a name like any other */
        {"../out.bin", OUTSIDE, OPEN},
        {"deep/../../out.bin", OUTSIDE, OPEN},
        {"deep/../a.bin", OUTSIDE, OPEN},
        {"..", OUTSIDE, SPECIAL},
        {"..\\out.bin", OUTSIDE, MISSING},
        {"deep\\..\\..\\out.bin", OUTSIDE, MISSING},
        {"\\\\host\\share", OUTSIDE, MISSING},
        {"/etc/passwd", OUTSIDE, OPEN},
        {"//etc/passwd", OUTSIDE, OPEN},
        {"/dev/zero", OUTSIDE, SPECIAL},
        {"absolute", OUTSIDE, OPEN},
        {"file-out", OUTSIDE, OPEN},
        {"link-to-link", OUTSIDE, OPEN},
        {"folder-out/out.bin", OUTSIDE, OPEN},
        {"folder-out/cell2/out.bin", OUTSIDE, OPEN},
        {"deep/er/up-out", OUTSIDE, OPEN},
        {"zero", OUTSIDE, SPECIAL},
        {"loop", MISSING, MISSING},
        {"none", MISSING, MISSING},
        {"a.bin/more", MISSING, MISSING},
        {"pipe", SPECIAL, SPECIAL}, /* would block for ever */
        {"socket", SPECIAL, SPECIAL},
        {"deep", SPECIAL, SPECIAL},
        {".", SPECIAL, SPECIAL},
        {"", SCHEME, SCHEME},
        {"file:a.bin", SCHEME, SCHEME},
        {"file:///etc/passwd", SCHEME, SCHEME},
        {"FILE:/etc/passwd", SCHEME, SCHEME},
        {"http://localhost/a.bin", SCHEME, SCHEME},
        {"C:\\a.bin", SCHEME, SCHEME},
        {"c:a.bin", SCHEME, SCHEME},
    };
    for (size_t i = 0; i < sizeof attempts / sizeof attempts[0]; ++i) {
        const struct attempt *a = &attempts[i];
        enum pbnds_jail jail;
        const char *text = what_opens(a->path, false, &jail);
        if ((int)jail != a->closed || strcmp(text, "out") == 0) {
            fail_msg("%s gives %d, \"%s\"", a->path, jail, text);
        }
        (void)what_opens(a->path, true, &jail);
        if ((int)jail != a->external) fail_msg("%s opened up gives %d", a->path, jail);
    }
    int fd = -1;
    assert_int_equal(pbnds_jail_open(CELL, "a.bin\0.png", 10, true, &fd),
                     PBNDS_JAIL_SCHEME);
    assert_int_equal(pbnds_jail_open("no-such", "a.bin", 5, false, &fd),
                     PBNDS_JAIL_MISSING);
}

/** Swaps a file of the folder with a link that leads out, for ever. */
static void swap_for_ever(void)
{
    for (unsigned i = 0;; ++i) {
        const char *next = CELL "/next";
        (void)unlink(next);
        if (i % 2) {
            if (symlink("../out.bin", next) != 0) _exit(1);
        } else if (link(CELL "/a.bin", next) != 0) {
            _exit(1);
        }
        (void)rename(next, CELL "/swapped");
    }
}

static void a_swapped_link_gives_nothing(void **state)
{
    (void)state;
    link_to("../out.bin", CELL "/swapped");
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) swap_for_ever();
    int opened = 0, leaked = 0;
    for (int i = 0; i < 20000 || (opened == 0 && i < 2000000); ++i) {
        enum pbnds_jail jail;
        const char *text = what_opens("swapped", false, &jail);
        opened += jail == PBNDS_JAIL_OPEN;
        leaked += strcmp(text, "out") == 0;
    }
    (void)kill(child, SIGKILL);
    (void)waitpid(child, NULL, 0);
    assert_int_equal(leaked, 0);
    assert_true(opened > 0);
}

/* ---- the same through a scene file ------------------------------------------------ */

static enum pbnds_status load_buffer(const char *uri,
                                     const struct pbnds_gltf_options *options)
{
    char buffer[400];
    struct pbnds_scene s;
    (void)snprintf(buffer, sizeof buffer, "{\"byteLength\":144,\"uri\":\"%s\"}", uri);
    char *json = edit(square_json, "{\"byteLength\":144}", buffer);
    put(CELL "/square.gltf", json);
    free(json);
    const enum pbnds_status status =
        pbnds_gltf_load(CELL "/square.gltf", options, NULL, &s, &fault);
    pbnds_scene_free(&s);
    return status;
}

static void the_option_opens_files_and_nothing_else(void **state)
{
    (void)state;
    const struct pbnds_gltf_options external = {.allow_external = true};
    assert_int_equal(
        pbnds_file_write(ROOT "/square.bin", &square, sizeof square, &fault), PBNDS_OK);
    static const char *const outside[] = {"../square.bin", "%2e%2e/square.bin",
                                          ".%2E/square.bin", "%2e%2e%2fsquare.bin",
                                          "folder-out/square.bin"};
    for (size_t i = 0; i < sizeof outside / sizeof outside[0]; ++i) {
        assert_int_equal(load_buffer(outside[i], NULL), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "--allow-external"));
        assert_int_equal(load_buffer(outside[i], &external), PBNDS_OK);
    }
    char here[600], path[700];
    assert_non_null(getcwd(here, sizeof here));
    (void)snprintf(path, sizeof path, "%s/" ROOT "/square.bin", here);
    if (strlen(path) < 300) {
        assert_int_equal(load_buffer(path, NULL), PBNDS_ERROR_FORMAT);
        assert_int_equal(load_buffer(path, &external), PBNDS_OK);
    }
    static const char *const never[] = {"file:../square.bin", "file:///etc/passwd",
                                        "http://localhost/square.bin", "ftp:a",
                                        "C:/square.bin"};
    for (size_t i = 0; i < sizeof never / sizeof never[0]; ++i) {
        assert_int_equal(load_buffer(never[i], &external), PBNDS_ERROR_FORMAT);
    }
    assert_int_equal(load_buffer("pipe", &external), PBNDS_ERROR_IO);
    assert_int_equal(load_buffer("/dev/zero", &external), PBNDS_ERROR_IO);
    assert_int_equal(load_buffer("%252e%252e/square.bin", NULL), PBNDS_ERROR_IO);
    assert_int_equal(load_buffer("DATA:;base64,AAAA", NULL), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "144")); /* it was read: three bytes */
}

static void names_may_be_of_any_letters(void **state)
{
    (void)state;
    static const char *const files[] = {CELL "/\xc3\xa9.bin",
                                        CELL "/\xf0\x9f\x98\x80.bin"};
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(pbnds_file_write(files[i], &square, sizeof square, &fault),
                         PBNDS_OK);
    }
    static const char *const uris[] = {"\xc3\xa9.bin",       "\\u00e9.bin",
                                       "%C3%A9.bin",         "\xf0\x9f\x98\x80.bin",
                                       "\\ud83d\\uDE00.bin", "%f0%9f%98%80.bin"};
    for (size_t i = 0; i < sizeof uris / sizeof uris[0]; ++i) {
        if (load_buffer(uris[i], NULL) != PBNDS_OK) fail_msg("%s", fault.message);
    }
    static const char *const halves[] = {"\\ud83d.bin", "\\ude00.bin",
                                         "\\ud83d\\u0041.bin", "\\ud83d", "\\u"};
    for (size_t i = 0; i < sizeof halves / sizeof halves[0]; ++i) {
        assert_int_not_equal(load_buffer(halves[i], NULL), PBNDS_OK);
    }
}

static void a_file_may_not_be_too_large(void **state)
{
    (void)state;
    const struct pbnds_gltf_options small = {.max_file = 143};
    struct pbnds_scene s;
    assert_int_equal(
        pbnds_file_write(CELL "/square.bin", &square, sizeof square, &fault), PBNDS_OK);
    assert_int_equal(load_buffer("square.bin", NULL), PBNDS_OK);
    assert_int_equal(pbnds_gltf_load(CELL "/square.gltf", &small, NULL, &s, &fault),
                     PBNDS_ERROR_MEMORY); /* the document itself */
    assert_non_null(strstr(fault.message, "square.gltf"));
    const struct pbnds_gltf_options medium = {.max_file = 2048};
    assert_int_equal(truncate(CELL "/square.bin", 2049), 0);
    assert_int_equal(pbnds_gltf_load(CELL "/square.gltf", &medium, NULL, &s, &fault),
                     PBNDS_ERROR_MEMORY);
    assert_non_null(strstr(fault.message, "--max-file"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_out_is_closed),
        cmocka_unit_test(a_swapped_link_gives_nothing),
        cmocka_unit_test(the_option_opens_files_and_nothing_else),
        cmocka_unit_test(names_may_be_of_any_letters),
        cmocka_unit_test(a_file_may_not_be_too_large),
    };
    return cmocka_run_group_tests(tests, build, NULL);
}
