// A map of points on walls, from range beams, by which a robot corrects where it believes itself to
// be.
//
// The map is a square window of cells that moves with the robot and forgets everything outside it.
// A cell keeps the first point that was seen in it, so in a world that does not change the map stops
// changing too. Each scan is matched with the map: every beam's end should be on the line through
// the two points of the map that are nearest to it, and the pose that makes their distances
// smallest is the robot's.
//
// Sources: Andrea Censi, "An ICP variant using a point-to-line metric", IEEE International
// Conference on Robotics and Automation (2008). For the search over headings before it: Edwin B.
// Olson, "Real-time correlative scan matching", same conference (2009).

#ifndef WG_SCAN_MAP_H
#define WG_SCAN_MAP_H

#include <stdint.h>

#include "wg_controllers.h"

// A pose in the map's frame: m, and rad in [-pi, pi).
typedef struct WgMapPose {
    double x;
    double y;
    double heading;
} WgMapPose;

// Returns the pose at which a scan fits the map.
//
// likely: the pose from the wheels; along a direction that the scan does not determine, it stays.
// doubt:  rad: by how much its heading may be wrong.
WgMapPose wg_match_scan(const WgScanMap *map, const WgObservation *seen, WgMapPose likely, double doubt);

// Adds a scan to the map.
//
// told:    (WG_MOST_BEAMS, 2) receives the points that are new, m.
// Returns their number.
int64_t wg_add_scan(WgScanMap *map, const WgObservation *seen, WgMapPose at, double told[][2]);

#endif
