// Controllers of the library with one realistic fault each, to measure fault finding by.

#ifndef WG_FAULTS_H
#define WG_FAULTS_H

#include <stdint.h>

#include "worldgen_controller.h"

typedef struct WgFault {
    const char *name;
    WgAct act;
    int64_t room;  // numbers of memory behind those of the controller without the fault, 0 at reset
} WgFault;

// The fault of a name; NULL if the name is unknown.
const WgFault *wg_fault(const char *name);

#endif
