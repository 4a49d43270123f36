// The Q-learning robot's table; its C file is written by `python -m benchmarks.train_q_learning`.

#ifndef WG_Q_TABLE_H
#define WG_Q_TABLE_H

#include "wg_controllers.h"

// Value of each turn, thousandths, in each situation.
extern const int16_t wg_q_table[WG_Q_SITUATIONS][WG_Q_TURNS];

#endif
