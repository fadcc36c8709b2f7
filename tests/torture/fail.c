/* Preloaded into the program by the tests of this folder: makes one of its calls fail, or all
 * from one on. What is to fail is in the environment:
 *
 *   FAIL_UNDER=FOLDER   counts calls that need room on the disk, for files below the folder (an
 *                       absolute path); what is cut or removed needs none
 *   FAIL_CALL=N         the N-th of them fails; 0 for none
 *   FAIL_ERRNO=E        with this error
 *   FAIL_ALLOCATION=N   the N-th allocation fails; 0 for none
 *   FAIL_FOR_GOOD=1     so do all calls after it; a write that fails first writes half of its
 *                       bytes, as on a disk that has room for so many. Of the allocations, those
 *                       of FAIL_FROM bytes on fail
 *   FAIL_LOG=FILE       gets a line for each of the first failures, and the counts at the end
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

/* The C library's own, by the names that it keeps for those who take its place. */
extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

static const char *under, *log_file;
static long call_at, allocation_at, from, calls, allocations;
static int error, for_good, ready, half_written;

static long number(const char *name)
{
    const char *value = getenv(name);
    return value ? atol(value) : 0;
}

static void report(const char *what, long n, size_t bytes)
{
    char line[128];
    if (!log_file)
        return;
    int length = snprintf(line, sizeof line, "%s %ld %zu\n", what, n, bytes);
    int fd = syscall(SYS_openat, AT_FDCWD, log_file, O_WRONLY | O_CREAT | O_APPEND, 0666);
    if (fd < 0)
        return;
    syscall(SYS_write, fd, line, length);
    syscall(SYS_close, fd);
}

__attribute__((constructor)) static void begin(void)
{
    under = getenv("FAIL_UNDER");
    log_file = getenv("FAIL_LOG");
    call_at = number("FAIL_CALL");
    allocation_at = number("FAIL_ALLOCATION");
    error = number("FAIL_ERRNO");
    for_good = number("FAIL_FOR_GOOD");
    from = number("FAIL_FROM");
    ready = 1;
}

__attribute__((destructor)) static void end(void)
{
    long a = allocations, c = calls;
    ready = 0;
    report("calls", c, 0);
    report("allocations", a, 0);
}

static int is_below(const char *path)
{
    size_t n = under ? strlen(under) : 0;
    return ready && n && !strncmp(path, under, n) && (path[n] == '/' || !path[n]);
}

static int is_open_below(int fd)
{
    char name[64], path[4096];
    if (!ready || !under)
        return 0;
    snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    ssize_t n = syscall(SYS_readlinkat, AT_FDCWD, name, path, sizeof path - 1);
    if (n < 0)
        return 0;
    path[n] = 0;
    return is_below(path);
}

/* Whether a call on a file below the folder is to fail. */
static int fails(const char *what)
{
    long n = __atomic_add_fetch(&calls, 1, __ATOMIC_RELAXED);
    if (!call_at || n < call_at || (n > call_at && !for_good))
        return 0;
    if (n < call_at + 3)
        report(what, n, 0);
    errno = error;
    return 1;
}

static ssize_t write_half(int fd, const void *bytes, size_t n)
{
    if (for_good && n > 1 && !half_written) {
        half_written = 1;
        return syscall(SYS_write, fd, bytes, n / 2);
    }
    errno = error;
    return -1;
}

ssize_t write(int fd, const void *bytes, size_t n)
{
    if (is_open_below(fd) && fails("write"))
        return write_half(fd, bytes, n);
    return syscall(SYS_write, fd, bytes, n);
}

ssize_t writev(int fd, const struct iovec *pieces, int n)
{
    return is_open_below(fd) && fails("writev") ? -1 : syscall(SYS_writev, fd, pieces, n);
}

int fsync(int fd)
{
    return is_open_below(fd) && fails("fsync") ? -1 : syscall(SYS_fsync, fd);
}

int fdatasync(int fd)
{
    return is_open_below(fd) && fails("fdatasync") ? -1 : syscall(SYS_fdatasync, fd);
}

static int open_file(const char *path, int flags, mode_t mode)
{
    int writes = (flags & O_ACCMODE) != O_RDONLY || flags & O_CREAT;
    if (writes && is_below(path) && fails("open"))
        return -1;
    return syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

static mode_t mode_of(int flags, va_list rest)
{
    return flags & (O_CREAT | __O_TMPFILE) ? (mode_t)va_arg(rest, int) : 0;
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = mode_of(flags, rest);
    va_end(rest);
    return open_file(path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = mode_of(flags, rest);
    va_end(rest);
    return open_file(path, flags | O_LARGEFILE, mode);
}

int rename(const char *old, const char *new)
{
    if (is_below(new) && fails("rename"))
        return -1;
    return syscall(SYS_renameat2, AT_FDCWD, old, AT_FDCWD, new, 0);
}

int mkdir(const char *path, mode_t mode)
{
    return is_below(path) && fails("mkdir") ? -1 : syscall(SYS_mkdirat, AT_FDCWD, path, mode);
}

/* Whether an allocation is to fail. */
static int starves(size_t bytes)
{
    if (!ready)
        return 0;
    long n = __atomic_add_fetch(&allocations, 1, __ATOMIC_RELAXED);
    if (!allocation_at || n < allocation_at)
        return 0;
    if (n > allocation_at && !(for_good && bytes >= (size_t)from))
        return 0;
    if (n == allocation_at)
        report("allocation", n, bytes);
    return 1;
}

void *malloc(size_t n)
{
    if (starves(n)) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_malloc(n);
}

void *calloc(size_t n, size_t size)
{
    if (starves(n * size)) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_calloc(n, size);
}

void *realloc(void *old, size_t n)
{
    if (n && starves(n)) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_realloc(old, n);
}

void *memalign(size_t alignment, size_t n)
{
    if (starves(n)) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_memalign(alignment, n);
}

void *aligned_alloc(size_t alignment, size_t n)
{
    return memalign(alignment, n);
}

int posix_memalign(void **out, size_t alignment, size_t n)
{
    void *found = memalign(alignment, n);
    if (!found)
        return ENOMEM;
    *out = found;
    return 0;
}

void *mmap64(void *at, size_t n, int protection, int flags, int fd, off64_t offset)
{
    if (flags & MAP_ANONYMOUS && starves(n)) {
        errno = ENOMEM;
        return MAP_FAILED;
    }
    return (void *)syscall(SYS_mmap, at, n, protection, flags, fd, offset);
}

void *mmap(void *at, size_t n, int protection, int flags, int fd, off_t offset)
{
    return mmap64(at, n, protection, flags, fd, offset);
}
