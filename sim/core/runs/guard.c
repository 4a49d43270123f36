// Feature macros come before every header: signals, timers and the clock of a process are POSIX.
#if defined(__linux__)
#define _GNU_SOURCE
#elif defined(__APPLE__)
#define _DARWIN_C_SOURCE
#elif !defined(_WIN32)
#define _XOPEN_SOURCE 700
#endif

#include "wg_guard.h"

#include <stddef.h>
#include <string.h>

#include "wg_runs.h"

int64_t wg_call_run(const WgCall *call)
{
    return wg_episode_run(call->objects[0], call->number);
}

int64_t wg_call_batch(const WgCall *call)
{
    return wg_batch_run(call->objects[0], call->number);
}

int64_t wg_call_first_edit(const WgCall *call)
{
    void *const *objects = call->objects;
    const WgGrid *old = objects[3];
    return wg_first_edit(objects[0], objects[1], objects[2], *old, objects[4], call->number, objects[5], objects[6]);
}

int64_t wg_call_fleet(const WgCall *call)
{
    return wg_fleet_run(call->objects[0], call->number);
}

int64_t wg_call_reset(const WgCall *call)
{
    const WgReset *reset = (const WgReset *)call->objects[1];
    return wg_cage_reset(call->objects[0], *reset);
}

int64_t wg_call_offer(const WgCall *call)
{
    const WgOffer *offer = call->objects[0];
    void *library = offer->open(offer->file, (int)offer->flags);
    void *found = library != NULL ? offer->find(library, offer->function) : NULL;
    if (found == NULL) {
        return 0;
    }
    // ISO C does not convert an object's address into a function's.
    const WgControllerInfo *(*describe)(void);
    memcpy((void *)&describe, (const void *)&found, sizeof describe);
    const WgControllerInfo *info = describe();
    return info != NULL && info->abi == WG_CONTROLLER_ABI;  // reads it, which may be a fault too
}

#if defined(_WIN32)

int64_t wg_page_size(void)
{
    return 4096;
}

void *wg_map_fenced(int64_t fence, int64_t first_size, int64_t second_size)
{
    (void)fence;
    (void)first_size;
    (void)second_size;
    return NULL;
}

int64_t wg_guard_start(WgCall *call, int asked, int answered)
{
    (void)call;
    (void)asked;
    (void)answered;
    return -1;
}

double wg_guard_seconds(int64_t process)
{
    (void)process;
    return -1.0;
}

#else

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

enum { LOOK_AROUND = 500000 };  // us between two checks that the owner still exists

static volatile sig_atomic_t owner;  // process that makes calls; set only there

// Ends this process if its owner has ended: a controller that hangs would keep it running forever.
static void look_for_owner(int number)
{
    (void)number;
    if (getppid() != (pid_t)owner) {
        _exit(1);
    }
}

// Resets signals to a program's initial state, except Ctrl-C, which belongs to the owner, and the
// check for the owner.
static void set_signals(void)
{
    for (int number = 1; number < NSIG; number++) {
        (void)signal(number, SIG_DFL);  // some cannot be set
    }
    (void)signal(SIGINT, SIG_IGN);
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = look_for_owner;
    action.sa_flags = SA_RESTART;
    sigaction(SIGALRM, &action, NULL);
    struct itimerval often = {{0, LOOK_AROUND}, {0, LOOK_AROUND}};
    setitimer(ITIMER_REAL, &often, NULL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

// Gives a controller no input, sends what it prints to standard error because standard output is for
// results, and prevents core files as large as the program.
static void close_off(void)
{
    int nothing = open("/dev/null", O_RDWR);
    if (nothing >= 0) {
        dup2(nothing, STDIN_FILENO);
    }
    if (dup2(STDERR_FILENO, STDOUT_FILENO) < 0 && nothing >= 0) {
        dup2(nothing, STDOUT_FILENO);  // standard error is closed
    }
    (void)setvbuf(stdout, NULL, _IOLBF, BUFSIZ);  // so that a fault loses no whole line
    struct rlimit no_file = {0, 0};
    setrlimit(RLIMIT_CORE, &no_file);
}

static WgCall *served;  // the call of this process; set only there

// Notes the address that could not be used, and lets the signal end the process.
static void note_fault(int number, siginfo_t *info, void *context)
{
    (void)context;
    (void)signal(number, SIG_DFL);
    if (info->si_code > 0) {
        served->fault = (uint64_t)(uintptr_t)info->si_addr;
    } else {
        (void)raise(number);  // sent by a program: returning would not end this one
    }
}

// Notes faults, on a stack of their own, because the stack itself may be what ran out.
static void note_faults(WgCall *call)
{
    served = call;
    call->fault = 0;
    stack_t stack;
    memset(&stack, 0, sizeof stack);
    stack.ss_size = 1 << 16;
    stack.ss_sp = malloc(stack.ss_size);
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_sigaction = note_fault;
    action.sa_flags = SA_SIGINFO;
    if (stack.ss_sp != NULL && sigaltstack(&stack, NULL) == 0) {
        action.sa_flags |= SA_ONSTACK;
    }
    sigaction(SIGSEGV, &action, NULL);
    sigaction(SIGBUS, &action, NULL);
}

static _Noreturn void serve(WgCall *call, int asked, int answered)
{
    for (;;) {
        char byte = 0;
        ssize_t count = read(asked, &byte, 1);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count != 1) {
            _exit(0);  // the owner has closed its end
        }
        call->result = call->work(call);
        (void)fflush(stdout);  // this process may be killed before the next call
        call->done = 1;
        do {
            count = write(answered, &byte, 1);
        } while (count < 0 && errno == EINTR);
        if (count != 1) {
            _exit(0);  // or a controller has closed this end
        }
    }
}

int64_t wg_guard_start(WgCall *call, int asked, int answered)
{
    // No signal may arrive in the new process before it has its own handlers.
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pid_t parent = getpid();
    (void)fflush(stdout);  // otherwise the new process would write the same text again
    pid_t process = fork();
    if (process == 0) {
        owner = (sig_atomic_t)parent;
        close_off();
        set_signals();
        note_faults(call);
        serve(call, asked, answered);
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return process;
}

int64_t wg_page_size(void)
{
    return sysconf(_SC_PAGESIZE);
}

void *wg_map_fenced(int64_t fence, int64_t first_size, int64_t second_size)
{
    // Reserve addresses for all of it, and put the shared pages there.
    size_t size = (size_t)(3 * fence + first_size + second_size);
    char *base = mmap(NULL, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (base == MAP_FAILED) {
        return NULL;
    }
    char *first = base + fence;
    char *second = first + first_size + fence;
    int flags = MAP_SHARED | MAP_ANONYMOUS | MAP_FIXED;
    if (mmap(first, (size_t)first_size, PROT_READ | PROT_WRITE, flags, -1, 0) == MAP_FAILED
        || mmap(second, (size_t)second_size, PROT_READ | PROT_WRITE, flags, -1, 0) == MAP_FAILED) {
        munmap(base, size);
        return NULL;
    }
    return first;
}

double wg_guard_seconds(int64_t process)
{
#if defined(__linux__)
    clockid_t clock;
    struct timespec time;
    if (clock_getcpuclockid((pid_t)process, &clock) == 0 && clock_gettime(clock, &time) == 0) {
        return (double)time.tv_sec + (double)time.tv_nsec / 1e9;
    }
#else
    (void)process;
#endif
    return -1.0;
}

#endif
