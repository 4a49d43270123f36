// Feature macros come before every header: kill, poll and the clock are POSIX.
#if defined(__linux__)
#define _GNU_SOURCE  // and syscall
#elif !defined(_WIN32)
#define _POSIX_C_SOURCE 200809L
#endif

#include "guard.h"

#include <stddef.h>
#include <string.h>

const char *const WG_HANG = "no answer";

#if defined(_WIN32)

int64_t wg_guard_bytes(int64_t memory_size)
{
    (void)memory_size;
    return 0;
}

WgAct wg_guarded_act(int64_t slot)
{
    (void)slot;
    return NULL;
}

void wg_guard_open(WgGuard *guard, int64_t slot, int64_t memory_size, int64_t owner)
{
    (void)guard;
    (void)slot;
    (void)memory_size;
    (void)owner;
}

int64_t wg_guard_is_ready(const WgGuard *guard)
{
    (void)guard;
    return 0;
}

void wg_guard_end(const WgGuard *guard)
{
    (void)guard;
}

void wg_guard_serve(WgGuard *guard, WgAct act)
{
    (void)guard;
    (void)act;
}

#else

#include <errno.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#if defined(__linux__)
#include <linux/futex.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

static const int64_t DEADLINE = (int64_t)WG_GUARD_DEADLINE * 1000000;  // ns
static const int64_t LONG_GONE = 5000000000;    // ns after which a server that says nothing is not there any more
static const int64_t LOOK_AROUND = 200000000;   // ns between two looks whether the other process is still there
static const int OVER = 77;                     // exit code of a worker whose owner is gone

// A guard for each slot, and what it guards against two threads at once. They are set when a guard is opened: a WgAct
// has no argument that could carry them.
static WgGuard *_Atomic guards[WG_GUARDS];
static atomic_bool taken[WG_GUARDS];
static char errors[WG_GUARDS][WG_LONGEST_ERROR];

// How long a process has waited for its turn.
typedef struct Wait {
    int64_t looks;
    int64_t began;  // ns; 0: the clock has not been asked
} Wait;

static int64_t now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

// Sleeps until a turn is not `turn` any more, or a while has passed.
static void sleep_while(WgGuard *guard, uint32_t turn)
{
#if defined(__linux__)
    // The kernel looks at the turn itself, so none that changes meanwhile is missed. Giving the processor away in a loop
    // instead costs up to a time slice for each step where the machine is busy.
    struct timespec longest = {0, 50000000};
    atomic_fetch_add(&guard->sleepers, 1);
    syscall(SYS_futex, (uint32_t *)&guard->turn, FUTEX_WAIT, turn, &longest, NULL, 0);
    atomic_fetch_sub(&guard->sleepers, 1);
#else
    (void)guard;
    (void)turn;
    struct timespec pause = {0, 20000};
    nanosleep(&pause, NULL);
#endif
}

static void give_turn(WgGuard *guard, uint32_t turn)
{
    atomic_store(&guard->turn, turn);
#if defined(__linux__)
    if (atomic_load(&guard->sleepers) > 0) {
        syscall(SYS_futex, (uint32_t *)&guard->turn, FUTEX_WAKE, 1, NULL, NULL, 0);
    }
#endif
}

// Waits a little while it is somebody's turn, at first without giving the processor away: a step of most controllers
// takes less than a switch. Returns how long it has waited in all, ns; 0 as long as that is next to nothing.
static int64_t wait_a_little(Wait *wait, WgGuard *guard, uint32_t turn)
{
    wait->looks++;
    if (wait->looks < 1000) {
        return 0;
    }
    if (wait->began == 0) {
        wait->began = now();
    }
    sleep_while(guard, turn);
    return now() - wait->began;
}

int64_t wg_guard_bytes(int64_t memory_size)
{
    return (int64_t)sizeof(WgGuard) + memory_size * (int64_t)sizeof(double);
}

void wg_guard_open(WgGuard *guard, int64_t slot, int64_t memory_size, int64_t owner)
{
    guard->memory_size = memory_size;
    guard->owner = owner;
    if (slot >= 0 && slot < WG_GUARDS) {
        atomic_store(&guards[slot], guard);
    }
}

int64_t wg_guard_is_ready(const WgGuard *guard)
{
    return atomic_load(&guard->ready);
}

static void end_worker(const WgGuard *guard)
{
    int64_t worker = atomic_load(&guard->worker);
    if (worker > 0) {
        kill((pid_t)worker, SIGKILL);
    }
}

void wg_guard_end(const WgGuard *guard)
{
    end_worker(guard);
}

// What a worker that ended says, in the words that a program's end is reported in.
static void describe_end(int64_t status, char *error)
{
    int code = (int)status;
    const char *name = NULL;
    if (WIFSIGNALED(code)) {
        switch (WTERMSIG(code)) {
        case SIGSEGV:
            name = "SIGSEGV";
            break;
        case SIGABRT:
            name = "SIGABRT";
            break;
        case SIGBUS:
            name = "SIGBUS";
            break;
        case SIGFPE:
            name = "SIGFPE";
            break;
        case SIGILL:
            name = "SIGILL";
            break;
        case SIGKILL:
            name = "SIGKILL";
            break;
        case SIGTRAP:
            name = "SIGTRAP";
            break;
        default:
            break;
        }
        if (name != NULL) {
            (void)snprintf(error, WG_LONGEST_ERROR, "killed by %s", name);
        } else {
            (void)snprintf(error, WG_LONGEST_ERROR, "killed by signal %d", WTERMSIG(code));
        }
    } else {
        (void)snprintf(error, WG_LONGEST_ERROR, "exit code %d", WIFEXITED(code) ? WEXITSTATUS(code) : code);
    }
}

// Waits until it is not the worker's turn any more. A worker that takes too long is killed.
static const char *wait_for_answer(WgGuard *guard, char *error)
{
    Wait wait = {0, 0};
    bool killed = false;
    for (;;) {
        uint32_t turn = atomic_load(&guard->turn);
        if (turn == WG_ANSWERED) {
            if (guard->has_error) {
                memcpy(error, guard->error, WG_LONGEST_ERROR);
                return error;
            }
            return NULL;
        }
        if (turn == WG_ENDED) {
            if (killed) {
                return WG_HANG;
            }
            describe_end(guard->status, error);
            return error;
        }
        int64_t waited = wait_a_little(&wait, guard, turn);
        if (waited > LONG_GONE) {
            return "the process that runs the controller is gone";
        }
        if (waited > DEADLINE && !killed) {
            killed = true;
            end_worker(guard);
        }
    }
}

static void act_guarded(int64_t slot, const WgObservation *seen, double *memory, WgCommand *command)
{
    while (atomic_exchange(&taken[slot], true)) {
        sched_yield();
    }
    WgGuard *guard = atomic_load(&guards[slot]);
    int64_t beams = seen->beam_count < WG_MOST_BEAMS ? seen->beam_count : WG_MOST_BEAMS;
    guard->seen = *seen;
    guard->seen.beam_count = beams;
    if (beams > 0) {
        memcpy(guard->beams, seen->beams, (size_t)beams * sizeof(double));
    }
    if (guard->memory_size > 0) {
        memcpy(guard->memory, memory, (size_t)guard->memory_size * sizeof(double));
    }
    give_turn(guard, WG_WORKER);

    const char *error = wait_for_answer(guard, errors[slot]);
    if (error == NULL) {
        *command = guard->command;
        if (guard->memory_size > 0) {
            memcpy(memory, guard->memory, (size_t)guard->memory_size * sizeof(double));
        }
    }
    command->error = error;
    atomic_store(&guard->turn, WG_NOBODY);
    atomic_store(&taken[slot], false);
}

#define GUARDED(slot)                                                                              \
    static void act_guarded_##slot(const WgObservation *seen, double *memory, WgCommand *command) \
    {                                                                                              \
        act_guarded(slot, seen, memory, command);                                                  \
    }

GUARDED(0)
GUARDED(1)
GUARDED(2)
GUARDED(3)
GUARDED(4)
GUARDED(5)
GUARDED(6)
GUARDED(7)
GUARDED(8)
GUARDED(9)
GUARDED(10)
GUARDED(11)
GUARDED(12)
GUARDED(13)
GUARDED(14)
GUARDED(15)
GUARDED(16)
GUARDED(17)
GUARDED(18)
GUARDED(19)
GUARDED(20)
GUARDED(21)
GUARDED(22)
GUARDED(23)
GUARDED(24)
GUARDED(25)
GUARDED(26)
GUARDED(27)
GUARDED(28)
GUARDED(29)
GUARDED(30)
GUARDED(31)

WgAct wg_guarded_act(int64_t slot)
{
    static const WgAct acts[WG_GUARDS] = {
        act_guarded_0, act_guarded_1, act_guarded_2, act_guarded_3,
        act_guarded_4, act_guarded_5, act_guarded_6, act_guarded_7,
        act_guarded_8, act_guarded_9, act_guarded_10, act_guarded_11,
        act_guarded_12, act_guarded_13, act_guarded_14, act_guarded_15,
        act_guarded_16, act_guarded_17, act_guarded_18, act_guarded_19,
        act_guarded_20, act_guarded_21, act_guarded_22, act_guarded_23,
        act_guarded_24, act_guarded_25, act_guarded_26, act_guarded_27,
        act_guarded_28, act_guarded_29, act_guarded_30, act_guarded_31,
    };
    return slot >= 0 && slot < WG_GUARDS ? acts[slot] : NULL;
}

// Calls the controller whenever it is the worker's turn, forever.
static _Noreturn void work(WgGuard *guard, WgAct act)
{
    atomic_store(&guard->worker, (int64_t)getpid());
#if defined(__linux__)
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // it may hang when the server ends
#endif
    for (;;) {
        Wait wait = {0, 0};
        int64_t looked = 0;
        for (uint32_t turn; (turn = atomic_load(&guard->turn)) != WG_WORKER;) {
            atomic_store(&guard->ready, 1);
            int64_t waited = wait_a_little(&wait, guard, turn);
            if (waited - looked > LOOK_AROUND) {
                looked = waited;
                if (kill((pid_t)guard->owner, 0) != 0 && errno == ESRCH) {
                    _exit(OVER);
                }
            }
        }
        WgObservation seen = guard->seen;
        seen.beams = guard->beams;
        WgCommand command = {0.0, 0.0, 0.0, NULL};
        act(&seen, guard->memory, &command);
        guard->has_error = command.error != NULL;
        if (command.error != NULL) {
            strncpy(guard->error, command.error, WG_LONGEST_ERROR - 1);
        }
        guard->command = command;
        give_turn(guard, WG_ANSWERED);
    }
}

// Waits until a worker has ended; whether it was because the owner is gone. The worker holds the other end of a pipe.
static bool wait_for_end(WgGuard *guard, pid_t worker, int pipe_end)
{
    struct pollfd ends = {.fd = pipe_end, .events = POLLIN};
    while (poll(&ends, 1, (int)(LOOK_AROUND / 1000000)) == 0) {
        if (kill((pid_t)guard->owner, 0) != 0 && errno == ESRCH) {
            kill(worker, SIGKILL);
        }
    }
    int status = 0;
    while (waitpid(worker, &status, 0) < 0 && errno == EINTR) {
    }
    guard->status = status;
    return (WIFEXITED(status) && WEXITSTATUS(status) == OVER) || (kill((pid_t)guard->owner, 0) != 0 && errno == ESRCH);
}

void wg_guard_serve(WgGuard *guard, WgAct act)
{
    for (;;) {
        int ends[2];
        if (pipe(ends) != 0) {
            return;
        }
        pid_t worker = fork();
        if (worker < 0) {
            return;
        }
        if (worker == 0) {
            close(ends[0]);
            work(guard, act);
        }
        close(ends[1]);
        bool over = wait_for_end(guard, worker, ends[0]);
        close(ends[0]);
        if (over) {
            return;
        }
        uint32_t asked = WG_WORKER;
        if (atomic_compare_exchange_strong(&guard->turn, &asked, WG_ENDED)) {
            give_turn(guard, WG_ENDED);
        }
    }
}

#endif
