// Finds a fault by its name.

#include "faults.h"

#include <string.h>

static const WgFault *find(const WgFault *faults, size_t count, const char *name)
{
    for (size_t k = 0; k < count; k++) {
        if (strcmp(faults[k].name, name) == 0) {
            return &faults[k];
        }
    }
    return NULL;
}

const WgFault *wg_fault(const char *name)
{
    const WgFault *found = find(wg_faults_by_touch, wg_faults_by_touch_count, name);
    return found != NULL ? found : find(wg_faults_by_sight, wg_faults_by_sight_count, name);
}
