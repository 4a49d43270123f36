// Controllers that do not know where they are, or where the target is, but estimate it from the
// wheels and from the strength of the signal. Each estimates first and then drives like a
// controller of the library, which receives the estimates in place of the simulator's true values.
//
// Sources: position from the wheels is odometry as in Johann Borenstein, H. R. Everett and Liqiang
// Feng, "Where am I? Sensors and methods for mobile robot positioning", University of Michigan
// (1996), chapter 1; a place from the distances to a known one is trilateration, chapter 6 there.

#include "directions.h"
#include "lattice_map.h"
#include "library.h"
#include "mapper.h"
#include "scan_map.h"

static const double GAIN = 0.2;      // fraction of a distance error that is corrected in one step
static const double GATE = 0.3;      // m: a distance with a larger error is ignored
// m: distance between the two places of a bearing from two distances
static const double BASE = 0.25;
// m: distance that a robot without any signal so far drives before it turns
static const double SEARCH = 3.0;
static const double THERE = 0.15;    // m: closer than this to the end of that path, it turns

// rad and m: the robot matches its scan with its map where its wheels say that it has turned or moved
// further than this
static const double TURNED = 0.05;
static const double MOVED = 0.03;
static const double DOUBT = 1.0;     // share of a measured turn that may be wrong
// m and rad: smaller corrections are ignored, because the map's points are rounded
static const double DEAD = 0.001;
static const double PARTS = 16384.0;  // corrections are multiples of 1/PARTS m and rad
// share of the robot's radius: within this of a point on its map of scans, there is no room for it
static const double SEEN = 0.95;

enum { SEARCHES = 8 };  // directions of a search before they repeat, three eighths of a turn apart

// Returns the distance to the source, m, from the strength of its signal:
// 1 / (1 + squared distance in cells).
static double distance_by_signal(double signal, double cell)
{
    return cell * sqrt(wg_higher(0.0, 1.0 / signal - 1.0));
}

// Puts a position of the target into an observation.
static void show_target(WgObservation *seen, double x, double y)
{
    double dx = x - seen->x;
    double dy = y - seen->y;
    seen->target_heading = wg_angle_of(dx, dy);
    seen->target_distance = sqrt(dx * dx + dy * dy);
}

// Returns the observation of a robot that trusts its odometry,
// and notes in the first step where the target is.
static WgObservation by_odometry(const WgObservation *seen, WgReckoning *own)
{
    WgObservation estimated = *seen;
    if (own->known == 0.0) {
        own->known = 1.0;
        own->x = seen->odometry_x;
        own->y = seen->odometry_y;
        own->target_x = seen->odometry_x + seen->target_distance * wg_cos(seen->target_heading);
        own->target_y = seen->odometry_y + seen->target_distance * wg_sin(seen->target_heading);
        double cells = distance_by_signal(seen->signal, 1.0);
        own->cell = seen->signal > 0.0 && cells > 0.0 ? seen->target_distance / cells : 0.0;
    } else {
        // Rotate the measured displacement by the error of the heading when the step began.
        double dx = seen->odometry_x - own->odometry_x;
        double dy = seen->odometry_y - own->odometry_y;
        own->x += wg_cos(own->turned) * dx - wg_sin(own->turned) * dy;
        own->y += wg_sin(own->turned) * dx + wg_cos(own->turned) * dy;
    }
    own->odometry_x = seen->odometry_x;
    own->odometry_y = seen->odometry_y;
    estimated.x = own->x;
    estimated.y = own->y;
    estimated.heading = wg_wrap(seen->odometry_heading + own->turned);
    return estimated;
}

void wg_odometry_bug_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgReckoning *own = (WgReckoning *)memory;
    WgObservation estimated = by_odometry(seen, own);
    show_target(&estimated, own->target_x, own->target_y);
    wg_bug2_act(&estimated, (double *)(own + 1), command);
}

// Moves the estimated place towards or away from the target until their distance matches the
// signal.
static void correct_by_signal(const WgObservation *seen, WgReckoning *own)
{
    double dx = own->target_x - own->x;
    double dy = own->target_y - own->y;
    double far = sqrt(dx * dx + dy * dy);
    if (seen->signal <= 0.0 || own->cell <= 0.0 || far <= 0.0) {
        return;
    }
    double wrong = distance_by_signal(seen->signal, own->cell) - far;
    if (fabs(wrong) > GATE) {
        return;
    }
    own->x -= GAIN * wrong * dx / far;
    own->y -= GAIN * wrong * dy / far;
}

void wg_signal_mapper_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgReckoning *own = (WgReckoning *)memory;
    WgObservation estimated = by_odometry(seen, own);

    // Its heading comes from a compass, not from the wheels.
    own->turned = wg_wrap(seen->heading - seen->odometry_heading);
    estimated.heading = seen->heading;
    correct_by_signal(seen, own);
    estimated.x = own->x;
    estimated.y = own->y;
    show_target(&estimated, own->target_x, own->target_y);
    wg_mapper_act(&estimated, (double *)(own + 1), command);
}

// Returns the pose that the wheels and the last correction give.
static WgMapPose corrected(const WgObservation *seen, const WgReckoning *own, const WgScanMap *map)
{
    double along = wg_cos(own->turned);
    double across = wg_sin(own->turned);
    return (WgMapPose){
        map->shift_x + along * seen->odometry_x - across * seen->odometry_y,
        map->shift_y + across * seen->odometry_x + along * seen->odometry_y,
        wg_wrap(seen->odometry_heading + own->turned),
    };
}

// Rounds a correction, so that one that no longer changes anything repeats exactly.
static double in_parts(double value, double parts)
{
    return (double)wg_floor(value * parts + 0.5) / parts;
}

// Corrects the odometry so that the robot's pose is the one that its scan shows.
static void correct_by_scan(const WgObservation *seen, WgReckoning *own, WgScanMap *map, double turn)
{
    WgMapPose likely = corrected(seen, own, map);
    WgMapPose pose = wg_match_scan(map, seen, likely, wg_lower(DOUBT * turn, 0.5 * WG_PI));
    if (wg_distance(pose.x, pose.y, likely.x, likely.y) < DEAD && fabs(wg_wrap(pose.heading - likely.heading)) < DEAD) {
        return;
    }
    own->turned = in_parts(wg_wrap(pose.heading - seen->odometry_heading), PARTS);
    map->shift_x = 0.0;
    map->shift_y = 0.0;
    WgMapPose turned = corrected(seen, own, map);
    map->shift_x = in_parts(pose.x - turned.x, PARTS);
    map->shift_y = in_parts(pose.y - turned.y, PARTS);
}

void wg_scan_mapper_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgReckoning *own = (WgReckoning *)memory;
    WgMapperMemory *driver = (WgMapperMemory *)(own + 1);
    WgScanMap *map = (WgScanMap *)(driver->nodes + wg_map_words(driver));
    WgObservation estimated = *seen;
    bool begins = own->known == 0.0;
    if (begins) {
        by_odometry(seen, own);
    }

    // A scan is matched where the robot has moved enough for its wheels to be wrong, and then added
    // to the map.
    double turn = fabs(wg_wrap(seen->odometry_heading - map->scan_heading));
    double moved = wg_distance(seen->odometry_x, seen->odometry_y, map->scan_x, map->scan_y);
    double points[WG_MOST_BEAMS][2];
    int64_t count = 0;
    if (begins || turn > TURNED || moved > MOVED) {
        if (!begins) {
            correct_by_scan(seen, own, map, turn);
        }
        count = wg_add_scan(map, seen, corrected(seen, own, map), points);
        map->scan_x = seen->odometry_x;
        map->scan_y = seen->odometry_y;
        map->scan_heading = seen->odometry_heading;
    }
    WgMapPose pose = corrected(seen, own, map);
    own->x = pose.x;
    own->y = pose.y;
    estimated.x = pose.x;
    estimated.y = pose.y;
    estimated.heading = pose.heading;
    show_target(&estimated, own->target_x, own->target_y);
    wg_mapper_act(&estimated, (double *)driver, command);

    // What the scan shows for the first time blocks edges as a touch would.
    for (int64_t k = 0; k < count; k++) {
        wg_mapper_learn(seen, driver, points[k][0], points[k][1], wg_lower(driver->no_room, SEEN));
    }
}

// Estimates the target from two distances to it, measured BASE apart: of the two places that fit
// both, it takes the one closer to the direction of the signal.
static void cross_distances(const WgObservation *seen, WgReckoning *own, double far)
{
    double dx = seen->x - own->odometry_x;
    double dy = seen->y - own->odometry_y;
    double base = sqrt(dx * dx + dy * dy);
    double along = (own->far * own->far - far * far + base * base) / (2.0 * base);
    double across = sqrt(wg_higher(0.0, own->far * own->far - along * along));
    double best = INFINITY;
    for (int side = -1; side <= 1; side += 2) {
        double x = own->odometry_x + (along * dx - (double)side * across * dy) / base;
        double y = own->odometry_y + (along * dy + (double)side * across * dx) / base;
        double off = fabs(wg_wrap(wg_angle_of(x - seen->x, y - seen->y) - seen->signal_heading));
        if (off < best) {
            best = off;
            own->target_x = x;
            own->target_y = y;
        }
    }
}

static void remember_distance(const WgObservation *seen, WgReckoning *own, double far)
{
    own->odometry_x = seen->x;
    own->odometry_y = seen->y;
    own->far = far;
}

// Returns where a robot drives that has never received a signal: straight ahead, then elsewhere.
static void search(const WgObservation *seen, WgReckoning *own)
{
    bool begins = own->search == 0.0;
    double left = wg_distance(seen->x, seen->y, own->target_x, own->target_y);
    if (!begins && left > THERE) {
        return;
    }
    double direction = 0.375 * WG_WHOLE_TURN * own->search;
    own->search = own->search >= (double)SEARCHES ? 1.0 : own->search + 1.0;
    own->target_x = seen->x + SEARCH * wg_cos(direction);
    own->target_y = seen->y + SEARCH * wg_sin(direction);
}

// Estimates where the target is; without a signal, the estimate does not change.
static void locate_target(const WgObservation *seen, WgReckoning *own)
{
    if (seen->signal <= 0.0) {
        if (own->known == 0.0) {
            search(seen, own);
        }
        return;
    }
    double far = distance_by_signal(seen->signal, own->cell);
    if (own->known == 0.0) {
        own->known = 1.0;
        own->target_x = seen->x + far * wg_cos(seen->signal_heading);
        own->target_y = seen->y + far * wg_sin(seen->signal_heading);
        remember_distance(seen, own, far);
    } else if (wg_distance(seen->x, seen->y, own->odometry_x, own->odometry_y) > BASE) {
        cross_distances(seen, own, far);
        remember_distance(seen, own, far);
    }
}

// Returns the map's column or row of a place, limited to the map.
static double map_cell(double place, double corner, double pitch)
{
    enum { SIDE = sizeof((WgThreeLayerMemory *)0)->right / sizeof(double) };
    int64_t cell = wg_floor((place - corner) / pitch);
    return (double)wg_least(wg_most(cell, 0), SIDE - 1);
}

void wg_signal_three_layer_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgReckoning *own = (WgReckoning *)memory;
    WgThreeLayerMemory *layers = (WgThreeLayerMemory *)(own + 1);
    WgObservation estimated = *seen;
    locate_target(seen, own);
    show_target(&estimated, own->target_x, own->target_y);
    if (layers->laid != 0.0) {
        layers->target_x = map_cell(own->target_x, layers->corner_x, layers->pitch);
        layers->target_y = map_cell(own->target_y, layers->corner_y, layers->pitch);
    }
    wg_three_layer_act(&estimated, (double *)layers, command);
}
