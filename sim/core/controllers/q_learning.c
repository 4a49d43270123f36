// Q-learning: a table of the value of each turn in each situation, learned by driving in the
// simulator.
//
// Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's
// College, Cambridge (1989); Christopher J. C. H. Watkins and Peter Dayan, "Q-learning",
// Machine Learning 8 (1992).

#include <stddef.h>

#include "directions.h"
#include "library.h"
#include "q_table.h"

enum {
    LOOKS = 5,   // beams, eighths of a turn apart, that the robot looks along
    BEAMS = 8,
};

const int wg_q_turn_of[6] = {0, 1, 7, 2, 6, 4};

static const int LOOK_AT[LOOKS] = {0, 1, 2, 6, 7};
static const double IN_THE_WAY = 0.09;  // m: a gap of less than this is blocked

int64_t wg_q_situation(const WgObservation *seen, const WgQMemory *own)
{
    int64_t eighth = wg_floor_mod(wg_floor(wg_target_bearing(seen) / WG_WHOLE_TURN * 8.0 + 0.5), 8);
    double near = seen->radius + IN_THE_WAY;
    int64_t blocked = 0;
    for (int k = 0; k < LOOKS; k++) {
        if (seen->beams[LOOK_AT[k]] < near) {
            blocked |= 1 << k;
        }
    }
    return ((int64_t)own->turned * 8 + eighth) * 32 + blocked;
}

int64_t wg_q_value(int64_t situation, int64_t turn)
{
    return wg_q_table[situation][turn];
}

// Returns the turn with the highest value in the shipped table for a situation; the first wins a
// tie.
static int64_t best_of_table(int64_t situation)
{
    const int16_t *worths = wg_q_table[situation];
    int64_t best = 0;
    for (int64_t turn = 1; turn < WG_Q_TURNS; turn++) {
        if (worths[turn] > worths[best]) {
            best = turn;
        }
    }
    return best;
}

// Makes one step: decides if a decision is due, and drives on.
//
// best: the turn to take in each situation; NULL: the shipped table's.
static void drive(const WgObservation *seen, WgQMemory *own, WgCommand *command, const double *best)
{
    int turn = 0;
    if (own->wait <= 0.0 || seen->bump != 0.0) {
        if (seen->beam_count < BEAMS) {
            command->error = "IndexError: the robot has fewer than 8 range beams";
            return;
        }
        int64_t situation = wg_q_situation(seen, own);
        turn = wg_q_turn_of[best == NULL ? best_of_table(situation) : (int64_t)best[situation]];
        own->wait = WG_Q_DRIVEN;
        own->turned = 0.0;
        if (turn % 4 != 0) {
            own->turned = turn < 4 ? 1.0 : 2.0;
        }
    }
    own->wait -= 1.0;
    wg_steer(seen, command, (turn <= 4 ? turn : turn - 8) * (WG_WHOLE_TURN / 8.0), seen->top_speed);
}

void wg_q_learning_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    drive(seen, (WgQMemory *)memory, command, NULL);
}

void wg_q_learning_tuned_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgQTunedMemory *own = (WgQTunedMemory *)memory;
    drive(seen, &own->state, command, own->best);
}
