// Library controllers with one realistic fault each, to measure fault finding.

#ifndef WG_FAULTS_H
#define WG_FAULTS_H

#include <stdint.h>

#include "worldgen_controller.h"

typedef struct WgFault {
    const char *name;
    WgAct act;
    int64_t room;  // numbers of memory after those of the controller without the fault, 0 at reset
} WgFault;

// Returns the fault with a name; NULL if the name is unknown.
const WgFault *wg_fault(const char *name);

#endif
