// Boxes of poses that are split further and further.
//
// A box is free if the body is clear at all of its poses, full if it overlaps a wall at all of them, and
// mixed if neither is known. Mixed boxes can be split. Boxes know those next to them, except full ones.

#ifndef WG_BOXES_H
#define WG_BOXES_H

#include "runs.h"

// Headings of the ranges that a box of all headings is split into.
enum { WG_BASE_TURN = WG_TURN / 16 };

typedef enum WgBoxKind {
    WG_FREE = 0,
    WG_MIXED = 1,
    WG_FULL = 2,
    WG_SPLIT = 3,  // replaced by its parts
} WgBoxKind;

typedef struct WgBox {
    WgRange range;
    uint8_t kind;        // a WgBoxKind
    uint8_t halvings;    // how often it or what it is a part of was halved
    bool is_goal;        // free: it has a pose in the target; mixed: it may have one
    bool is_thin;        // free, and of no extent in some direction
    bool is_done;        // mixed: it is too small to be split
    int32_t first_solid;  // its rectangles, in the list of all
    int32_t solid_count;
    int32_t first_part;  // split: the parts
    int32_t part_count;
    int32_t *near;       // boxes next to it; some may be split or full by now
    int32_t near_count;
    int32_t near_room;
    int64_t cost[2];     // of the search from the start, and from the target
    int32_t round[2];    // in which that was found
    int32_t before[2];   // box before it on the path
    int32_t label[2];    // of the free boxes that are the last before it, or its own
} WgBox;

// Where the body should arrive.
typedef struct WgGoal {
    double x;  // lu
    double y;
    double radius;
    int64_t heading;  // the first one
    int64_t headings; // how many follow
} WgGoal;

typedef struct WgNumbers {
    int32_t *all;
    int64_t count;
    int64_t room;
} WgNumbers;

typedef struct WgBoxes {
    const WgWalls *walls;
    const WgBody *body;
    WgGoal goal;
    WgDiscs discs;
    WgSolids solids;
    int64_t period;  // headings after which the body looks the same
    WgBox *all;
    int64_t count;
    int64_t room;
    int32_t *lists;  // numbers of rectangles
    int64_t list_count;
    int64_t list_room;
    WgSpan **spans;  // ranges of headings, made when they are needed
    WgNumbers made;  // which of them
    int64_t tile;    // side of the boxes that all begins with, lu
    int64_t low;     // least x and y of the tiles
    int64_t high[2];
    int64_t tiles;   // the first boxes: tiles of all headings
    int64_t columns;
    int64_t rows;
} WgBoxes;

// Begins with tiles of all headings. Call wg_boxes_free whatever this returns.
WgStatus wg_boxes_make(WgBoxes *boxes, const WgWalls *walls, const WgBody *body, WgGoal goal);

// Splits a mixed box. It is done instead if it is too small.
WgStatus wg_boxes_split(WgBoxes *boxes, int64_t number);

// Adds a thin free box, and connects it with all that it touches but thin ones.
WgStatus wg_boxes_add_thin(WgBoxes *boxes, WgRange range);

// Returns true if two boxes share a face, or touch if one of them is thin.
bool wg_boxes_share_face(const WgBoxes *boxes, int64_t a, int64_t b);

// Connects two thin boxes if they touch.
WgStatus wg_boxes_connect(WgBoxes *boxes, int64_t a, int64_t b);

bool wg_numbers_add(WgNumbers *numbers, int32_t number);

// Lists the boxes that touch a closed range of poses; ``kinds`` has a bit for each WgBoxKind.
WgStatus wg_boxes_touching(const WgBoxes *boxes, const WgRange *range, unsigned kinds, WgNumbers *found);

// The span of a box's headings; NULL for all headings, or if memory runs out (status).
const WgSpan *wg_boxes_span(WgBoxes *boxes, int64_t heading, int64_t turn, WgStatus *status);

// Finds the pose of the target in a range that is nearest to its centre; false if it has none.
bool wg_goal_pose(const WgBoxes *boxes, const WgRange *range, WgBodyPose *pose);

void wg_boxes_free(WgBoxes *boxes);

#endif
