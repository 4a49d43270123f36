// Follows a path of a robot that turns on the spot with a car that may reverse.
//
// The car drives the shortest curve to a pose farther along the path; where a wall is in the way, to
// one half as far. Short curves stay as near to the path as one likes, so this works wherever the
// path keeps away from walls.
//
// Source: J.-P. Laumond, P. Jacobs, M. Taix and R. Murray, "A motion planner for nonholonomic mobile
// robots", IEEE Transactions on Robotics and Automation 10 (1994).

#include <math.h>
#include <stdlib.h>

#include "drive.h"

enum {
    MOST_CURVES = 6,  // tried to one pose
    MOST_HALVINGS = 24,
    AHEAD = 32,       // poses among which a shortcut is looked for
};

// Parts of a path shorter than this are not divided: 1/64 cell, lu.
static const double SHORTEST = 16.0;
// A detour is left out if the shortcut is shorter by this share.
static const double WORTH = 0.98;

// The path, with the length of what lies before each of its poses; a turn counts like an arc of
// the turning circle.
typedef struct Guide {
    const int64_t *poses;  // (count, 3)
    double *before;        // (count,) lu
    int64_t count;
} Guide;

// Where the car has been.
typedef struct Progress {
    WgCar car;
    WgCarPose pose;
    WgCarTrail trail;
    WgCarPose *stops;  // (room,) ends of curves
    double *length;    // (room,) of the curve to each of them
    int64_t count;
    int64_t room;
    bool has_arrived;
    bool has_no_room;
} Progress;

static bool make_guide(const WgCar *car, const int64_t *poses, int64_t count, Guide *guide)
{
    *guide = (Guide){poses, malloc((size_t)count * sizeof(double)), count};
    if (guide->before == NULL) {
        return false;
    }
    guide->before[0] = 0.0;
    for (int64_t k = 1; k < count; k++) {
        const int64_t *from = poses + 3 * (k - 1);
        const int64_t *to = poses + 3 * k;
        double dx = (double)(to[0] - from[0]);
        double dy = (double)(to[1] - from[1]);
        WgCarPart turn = {1, (double)wg_abs(wg_turn_between(from[2], to[2]))};
        guide->before[k] = guide->before[k - 1] + sqrt(dx * dx + dy * dy) + wg_car_length(car, turn);
    }
    return true;
}

// The pose of a path after some length.
static WgCarPose pose_after(const Guide *guide, double length)
{
    int64_t low = 0;
    int64_t high = guide->count - 1;
    while (high - low > 1) {
        int64_t middle = (low + high) / 2;
        if (guide->before[middle] <= length) {
            low = middle;
        } else {
            high = middle;
        }
    }
    const int64_t *from = guide->poses + 3 * low;
    const int64_t *to = guide->poses + 3 * high;
    double whole = guide->before[high] - guide->before[low];
    double share = whole > 0.0 ? fmin(1.0, (length - guide->before[low]) / whole) : 1.0;
    int64_t turn = (int64_t)floor(share * (double)wg_turn_between(from[2], to[2]) + 0.5);
    return (WgCarPose){(double)from[0] + share * (double)(to[0] - from[0]),
                       (double)from[1] + share * (double)(to[1] - from[1]), wg_car_heading(from[2] + turn)};
}

// Keeps the pose that the car has reached as a stop.
static void stop(Progress *progress, double length)
{
    if (progress->count == progress->room) {
        int64_t room = 2 * progress->room + 64;
        WgCarPose *stops = realloc(progress->stops, (size_t)room * sizeof *stops);
        progress->stops = stops != NULL ? stops : progress->stops;
        double *lengths = realloc(progress->length, (size_t)room * sizeof *lengths);
        progress->length = lengths != NULL ? lengths : progress->length;
        if (stops == NULL || lengths == NULL) {
            progress->has_no_room = true;
            return;
        }
        progress->room = room;
    }
    progress->stops[progress->count] = progress->pose;
    progress->length[progress->count] = length;
    progress->count++;
}

// Drives to a pose on a curve no longer than ``most``; returns false if none is clear.
static bool drive_to(Progress *progress, WgCarPose goal, double most)
{
    WgCarRoute routes[WG_MOST_CURVES];
    int64_t count = wg_car_routes(&progress->car, progress->pose, goal, routes);
    for (int64_t r = 0; r < wg_min(count, MOST_CURVES) && routes[r].length <= most; r++) {
        WgCarPose pose = progress->pose;
        int64_t kept = progress->trail.count;
        WgDriven driven =
            wg_car_drive(&progress->car, &pose, routes[r].parts, routes[r].count, true, &progress->trail);
        if (driven == WG_DRIVEN || driven == WG_ARRIVED) {
            progress->pose = pose;
            progress->has_arrived = driven == WG_ARRIVED;
            stop(progress, routes[r].length);
            return true;
        }
        progress->has_no_room = progress->has_no_room || driven == WG_NO_ROOM;
        progress->trail.count = kept;
    }
    return false;
}

// Drives the path, by halves where a curve to its end is not clear.
static void drive_along(Progress *progress, const Guide *guide, WgCarQuery *asked)
{
    // The ends of the parts that are still to be driven, the next one last.
    double ends[MOST_HALVINGS + 1] = {guide->before[guide->count - 1]};
    int64_t count = 1;
    double done = 0.0;
    while (count > 0 && !progress->has_arrived && !progress->has_no_room && asked->expanded < asked->most) {
        double end = ends[count - 1];
        asked->expanded++;
        if (drive_to(progress, pose_after(guide, end), INFINITY)) {
            done = end;
            count--;
        } else if (count <= MOST_HALVINGS && end - done > SHORTEST) {
            ends[count++] = 0.5 * (done + end);
        } else {
            return;
        }
    }
}

// Drives the stops again, and leaves out detours.
static void drive_stops(Progress *progress, const Progress *given)
{
    int64_t at = 0;
    while (at < given->count - 1 && !progress->has_arrived && !progress->has_no_room) {
        double detour = 0.0;
        int64_t last = wg_min(given->count - 1, at + AHEAD);
        for (int64_t next = at + 1; next <= last; next++) {
            detour += given->length[next];
        }
        // The farthest first.
        int64_t next = last;
        while (next > at && !drive_to(progress, given->stops[next], next > at + 1 ? WORTH * detour : INFINITY)) {
            detour -= given->length[next];
            next--;
        }
        if (next == at) {
            return;
        }
        at = next;
    }
}

static bool begin(Progress *progress, const WgCar *car)
{
    const WgCarQuery *asked = car->asked;
    *progress = (Progress){*car, {asked->start_x, asked->start_y, asked->start_heading}, {NULL, 0, 0}, NULL, NULL,
                           0, 0, false, false};
    progress->trail.values = malloc(3 * sizeof(int64_t));
    if (progress->trail.values == NULL) {
        return false;
    }
    progress->trail.count = progress->trail.room = 1;
    progress->trail.values[0] = (int64_t)floor(asked->start_x + 0.5);
    progress->trail.values[1] = (int64_t)floor(asked->start_y + 0.5);
    progress->trail.values[2] = asked->start_heading;
    stop(progress, 0.0);
    progress->has_arrived = wg_car_is_there(car, progress->pose);
    if (progress->has_no_room) {
        free(progress->trail.values);
        free(progress->stops);
        free(progress->length);
    }
    return !progress->has_no_room;
}

static void finish(Progress *progress, WgCarQuery *asked)
{
    if (progress->has_arrived && !progress->has_no_room) {
        free(asked->poses);
        asked->poses = progress->trail.values;
        asked->count = progress->trail.count;
    } else {
        free(progress->trail.values);
    }
    free(progress->stops);
    free(progress->length);
}

WgStatus wg_car_follow(const WgWalls *walls, WgCarQuery *asked, const int64_t *poses, int64_t count)
{
    asked->expanded = 0;
    asked->count = 0;
    asked->poses = NULL;
    bool is_valid = asked->body == NULL || wg_body_is_valid(walls, asked->body);
    if (!is_valid || count < 1 || asked->turning_radius <= 0.0 || asked->reverse == 0) {
        return WG_BAD_VALUE;
    }
    WgCar car = wg_car_of(walls, asked);
    Guide guide;
    Progress along;
    bool fits = make_guide(&car, poses, count, &guide);
    fits = fits && begin(&along, &car);
    if (!fits) {
        free(guide.before);
        return WG_OUT_OF_MEMORY;
    }
    drive_along(&along, &guide, asked);
    fits = !along.has_no_room;
    // Shortcuts are worth a second path, which replaces the first if it arrives as well.
    Progress shorter;
    if (fits && along.has_arrived && begin(&shorter, &car)) {
        drive_stops(&shorter, &along);
        finish(&along, asked);
        finish(&shorter, asked);
    } else {
        finish(&along, asked);
    }
    free(guide.before);
    return fits ? WG_OK : WG_OUT_OF_MEMORY;
}
