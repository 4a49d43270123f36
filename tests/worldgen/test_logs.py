"""Logs and plans as people have them: which columns are read, in which unit, and what is refused."""

import math

import pytest

from tests.helpers.raising import raises
from worldgen import FormatError, InvalidParameter
from worldgen.logs.reading import parse_log

ZEROS = ",".join(["0.0"] * 36)
ODOMETRY = "header.stamp.sec,header.stamp.nanosec,pose.pose.position.x,pose.pose.position.y"
QUATERNION = "field.pose.pose.orientation"


def lines(template, header=""):
    """Return a table of three samples: the robot drives from (2, 3) m to (4, 3) m in 2 s."""
    return header + "".join(template.format(i=i, x=2 + i) + "\n" for i in range(3))


# Each is the same drive, as another program writes it.
TIMED = {
    "TUM": lines("{i}.0 {x} 3 0 0 0 0 1", "# ground truth\n# timestamp tx ty tz qx qy qz qw\n"),
    "TUM without header": lines("{i}.0 {x} 3 0 0 0 0 1"),
    "dates": lines("160000000{i}.5 {x} 3 0 0 0 0 1"),
    "rostopic": lines(
        "160000000{i}000000000,160000000{i}100000000,odom,{x}.0,3.0,0.0,1.0,0.5",
        "%time,field.header.stamp,field.header.frame_id,field.pose.pose.position.x,"
        f"field.pose.pose.position.y,{QUATERNION}.z,{QUATERNION}.w,field.twist.twist.linear.x\n",
    ),
    "a stamp that nobody set": lines(
        "160000000{i}000000000,0,{x},3",
        "%time,field.header.stamp,field.pose.position.x,field.pose.position.y\n",
    ),
    "seconds and nanoseconds": lines("160000000{i},900000000,{x},3", f"{ODOMETRY}\n"),
    "PoseStamped": lines("160000000{i},5,map,{x}.0,3.0,0.0,0.0,0.0,0.0,1.0"),
    "PoseStamped without a frame": lines("{i},0,,{x},3,0,0,0,0,1"),
    "PoseWithCovarianceStamped": lines("{i},0,map,{x},3,0,0,0,0,1," + ZEROS),
    "Odometry": lines(
        "{i},0,odom,base_link,{x},3,0,0,0,0,1," + ZEROS + ",1.0,0,0,0,0,0.2," + ZEROS
    ),
    "Odometry --no-arr": lines(
        "{i},0,odom,base_link,{x},3,0,0,0,0,1,<array type: double[36]>,1.0,0,0,0,0,0.2,"
        "<array type: double[36]>"
    ),
    "milliseconds by date": lines("160000000{i}000,{x},3", "timestamp,pose_posX,pose_posY\n"),
    "milliseconds by speed": lines("{i}000,{x},3", "timestamp,x,y\n"),
    "nanoseconds by speed": lines("{i}000000000,{x},3", "time,x,y\n"),
    "microseconds by name": lines("{i}000000\t{x}\t3", "t_us\tx\ty\n"),
    "capitals, semicolons, decimal commas": lines("{i},0;{x},0;3,0", "TIME;X;Y\n"),
    "blanks": lines("  {i}.0   {x}   3.0", "  t    x    y\n"),
    "blanks, decimal commas": lines("{i},0 {x},0 3,0", "t x y\n"),
    "quoted decimal commas": lines('"{i},0","{x},0","3,0"', '"Time","X","Y"\n'),
    "units in brackets": lines("{i},{x}000,300", "Time (s),X [mm],Y [cm]\n"),
    "dates in words": lines("2024-05-01T12:00:0{i}.5Z,{x},3", "time,x,y\n"),
    "an index, velocities, a goal": lines("7,{i},{x},3,9,9,8,8", ",t,x,y,vx,vy,goal_x,goal_y\n"),
    "EuRoC": lines(
        "160000000{i}000000000,{x},3,0,1", "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_z [m],q_w []\n"
    ),
    "words before the first message": "WARNING: topic [/odom] is not published yet\n"
    + lines("{i},0,odom,base_link,{x},3,0,0,0,0,1"),
    "a row of units": lines("{i},{x},3", "time,x,y\n[s],[m],[m]\n"),
    "three columns, the first one dates": lines("160000000{i}.5 {x} 3"),
    "Chinese": lines("{i},{x},3", "时间,x坐标,y坐标\n"),
    "a clock in brackets": lines("{i},{x},3", "Time (UTC),x,y\n"),
    "units below the names": lines("{i}000,{x}000,3000", "time,x,y\n[ms],[mm],[mm]\n"),
    "comments among numbers": "t,x,y\n0,2,3\n# half way\n\n1,3,3\n2,4,3\n",
}  # fmt: skip
PLANS = {
    "x,y": "x,y\n2,3\n3,3\n4,3\n",
    "no header": "2 3\n3 3\n4 3\n",
    "race line": "0;2;3;0;0;2;0\n1;3;3;0;0;2;2.5\n2;4;3;0;0;3;0\n",
    "F1TENTH": "# 1f\n# s_m; x_m; y_m; psi_rad; vx_mps\n0; 2; 3; 0; 1\n1; 3; 3; 0; 1\n2; 4; 3; 0; 1\n",
    "poses": "2 3 0 0 0 0 1\n3 3 0 0 0 0 1\n4 3 0 0 0 0 1\n",
    "rostopic of a path": ",".join(
        ["%time", *(f"field.poses{i}.pose.position.{axis}" for i in range(3) for axis in "xy")]
    )
    + "\n1600000000000000000,2,3,3,3,4,3\n",
    "the last of two paths": "0,0,map,0,0,,9,9,0,0,0,0,1,0,0,,8,9,0,0,0,0,1\n"
    "5,0,map," + ",".join(f"0,0,,{x},3,0,0,0,0,1" for x in (2, 3, 4)) + "\n",
}


@pytest.mark.parametrize("text", TIMED.values(), ids=TIMED)
def test_logs_of_other_programs_are_read(text):
    found = parse_log(text, "log").trajectories[1]
    assert found.times == pytest.approx([found.times[0] + i for i in range(3)], abs=1e-6)
    assert list(found.x) == [2.0, 3.0, 4.0] and list(found.y) == [3.0] * 3
    assert not found.is_plan


@pytest.mark.parametrize("text", PLANS.values(), ids=PLANS)
def test_plans_are_read(text):
    found = parse_log(text, "plan", with_headings=True).trajectories[1]
    assert found.is_plan
    assert list(found.x) == [2.0, 3.0, 4.0] and list(found.y) == [3.0] * 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TIMED["TUM"], "TUM: 3 poses over 2 s"),
        (TIMED["dates"], "TUM: 3 poses over 2 s, counted from 1600000000.5 s"),
        (TIMED["rostopic"], "rostopic echo -p: 3 poses over 2 s, counted from 1600000000.1 s"),
        (TIMED["Odometry"], "ros2 topic echo --csv of Odometry: 3 poses over 2 s"),
        (PLANS["F1TENTH"], "F1TENTH's line: 3 poses without times, a plan"),
        (
            PLANS["race line"],
            "a race line (s; x; y; psi; kappa; vx; ax): 3 poses without times, a plan",
        ),
        (TIMED["microseconds by name"], "a table (t from t_us in us, x from x, y from y): 3 poses over 2 s"),
        (PLANS["x,y"], ""),
    ],
)  # fmt: skip
def test_a_log_says_what_it_was_read_as(text, said):
    assert parse_log(text, "log").read_as == said


HALF = math.sqrt(0.5)
NORTH = "\n0,2,2,{0}\n1,2,3,{0}\n2,2,4,{0}\n"


@pytest.mark.parametrize(
    ("text", "remark"),
    [
        ("t,x,y,yaw" + NORTH.format(math.pi / 2), ""),
        ("t,x,y,yaw_deg" + NORTH.format(90), "yaw_deg in degrees"),
        ("t,x,y,heading" + NORTH.format(90), "heading in degrees"),
        ("t,x,y,psi" + NORTH.format(0), "psi counted from the y axis"),
        ("t,x,y,yaw\n0,2,2,90\n1,2,3,-270\n2,2,3,90\n", "yaw in degrees"),
        (
            "t,x,y,heading\n0,2,2,{0}\n1,3,2,{0}\n2,4,2,{0}\n".format(math.pi / 2),
            "heading in rad, although degrees fit the moves; choose --columns yaw=heading:deg if it is in degrees",
        ),
        ("t,x,y,qz,qw" + NORTH.format(f"{HALF},{HALF}"), ""),
        ("t,x,y,q_x,q_y,q_z,q_w" + NORTH.format(f"0,0,{HALF},{HALF}"), ""),
    ],
)
def test_headings_are_turned_into_radians_from_the_x_axis(text, remark):
    log = parse_log(text, "log", with_headings=True)
    turned = [heading % (2 * math.pi) for heading in log.trajectories[1].headings]
    assert turned == pytest.approx([math.pi / 2] * 3)
    assert log.read_as.endswith(remark)


def test_chosen_columns_take_the_place_of_recognised_ones():
    text = "clock,gt_x,gt_y,est_x,est_y,turn\n0,9,9,2,3,90\n500,9,9,3,3,90\n"
    log = parse_log(
        text, "log", with_headings=True, columns="t=clock:ms, x=est_x, y=est_y, yaw=6:deg"
    )
    found = log.trajectories[1]
    assert list(found.times) == [0.0, 0.5] and list(found.x) == [2.0, 3.0]
    assert list(found.headings) == pytest.approx([math.pi / 2] * 2)
    assert parse_log(text, "log", columns="t=none,x=est_x,y=est_y").trajectories[1].is_plan
    bare = parse_log("0;2;3\n1;3;3\n", "log", columns="t=1,x=2,y=3").trajectories[1]
    assert not bare.is_plan and list(bare.x) == [2.0, 3.0]


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("t,gt_x,gt_y,est_x,est_y\n0,1,1,1,1\n", "x=gt_x,y=gt_y"),
        ("0,2,3\n1,3,3\n", "t=1,x=2,y=3"),
        ("wall_time,sim_time,x,y\n0,0,1,1\n3,1,1,1\n", "t=wall_time"),
        ("time,x,y\n0,0,0\n20,0.6,0\n40,1.2,0\n", "t=time:ms"),
        ("time,x,y\n0.25,0,0\n20.25,0.1,0\n40.25,0.2,0\n", "t=time:ms"),
        ("time,x,y\n0,0,0\n5,0.005,0\n10,0.01,0\n", "t=time:ms"),
        ("x,y,turn_angle\n2,2,100\n3,2,200\n", "yaw=turn_angle:deg"),
        ("t,x,y,yaw\n0,2,2,0.1\n1,2,2,4\n2,2,2,8\n", "yaw=yaw:deg"),
        ("t,x,y,heading\n0,2,2,90\n1,3,2,91\n", "yaw=heading:deg"),
        ("t,x,y,yaw\n0,2,2,44\n1,3,2,44\n", "yaw=yaw:deg"),
        ("t,x,y,yaw\n0,2,2,-0.6\n1,3,1.99,0\n2,4,1.99,0.6\n3,5,2,0\n", "yaw=yaw:deg"),
        ("0 2 3 0 1 0 0 0\n1 3 3 0 0.9801 0 0 0.1987\n", "qw=5,qx=6,qy=7,qz=8"),
        ("t,goal_x,goal_y\n0,1,1\n", "x=goal_x,y=goal_y"),
        ("t,x,y,robot_x,robot_y\n0,1,1,1,1\n", "x=x,y=y"),
    ],
)
def test_what_may_be_several_things_is_refused_with_a_way_to_choose(text, first):
    with raises(FormatError, "ambiguous-columns", needs=[f"--columns={first}"]):
        parse_log(text, "log", with_headings=True)


@pytest.mark.parametrize(
    ("text", "columns", "code"),
    [
        ("time,latitude,longitude\n0,48,11\n", "", "columns-missing"),
        ("t,x,y\n0,1,1\n", "x=east,y=north", "columns-missing"),
        ("%worldgen-grid 1\ncell_size = 0.1\n", "", "not-a-log"),
        (lines("{i},0,odom,base,{x},3,0,0,0,0,1") + "3,0,map,base,4,3,0,0,0,0,1\n", "", "several-frames"),
        ("t,x,y\n0,5,1,25,2,0\n1,5,1,25,2,0\n", "", "wrong-count"),
        ("1,2,3,4,5\n2,2,3,4,5\n", "", "ambiguous-columns"),
        # At 1 m/s the first column may be the distance or the time.
        ("0;2;3;0;.2;1;0\n1;3;3;0;.2;1;0\n2;4;3;0;.2;1;0\n", "", "ambiguous-columns"),
        ("0;2;3;0;0;2;0\n1;3;3;0;0;2;0\n2;4;3;0;0;3;0\n", "", "ambiguous-columns"),
        ("t [min],x,y\n0,1,1\n", "", "unknown-unit"),
        ("t_h,x,y\n0,1,1\n", "t=t_h", "unknown-unit"),
        ("t,x_ft,y_ft\n0,1,1\n", "", "unknown-unit"),
        ("t,x [km],y [km]\n0,1,1\n", "x=2,y=3", "unknown-unit"),
        ("0,0,map" + ",0,0,,1,1,0,0,0,0,1" * 128 + ",...\n", "", "line-too-short"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_rightly_is_refused(text, columns, code):
    with raises(FormatError, code):
        parse_log(text, "log", columns=columns)


MANY = 20_000


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("t,x" + MANY * "(" + ",y\n0,1,1\n", "too-few-samples"),
        (f"t,{MANY // 10 * 'x,y,'}z\n", "ambiguous-columns"),
        (f"{20 * 'time,'}x,y\n{20 * '0,'}1,1\n", "ambiguous-columns"),
        ("t,x,y\n" + 10 * MANY * "1", "too-few-samples"),
        ("t,x,y\n0,1,1\n1,1," + 10 * MANY * "a" + "\n", "invalid-csv"),
    ],
    ids=["brackets", "columns of positions", "columns of times", "a long line", "a long field"],
)
def test_a_table_beyond_measure_is_refused_at_once(text, code):
    with raises(FormatError, code):
        parse_log(text, "log")


def test_a_long_line_is_read_if_its_fields_are_short():
    path = "0,0,map," + ",".join(f"0,0,,{x},3,0,0,0,0,1" for x in range(7000)) + "\n"
    assert len(path) > 131_072 and len(parse_log(path, "log").trajectories[1].x) == 7000


def test_headings_of_two_robots_are_counted_for_each():
    text = "t,robot,x,y,heading\n0,1,1,1,6\n0,2,2,2,0\n1,1,1,1,8\n1,2,2,2,0\n"
    found = parse_log(text, "log", 2, with_headings=True).trajectories
    assert [list(found[robot].headings) for robot in (1, 2)] == [[6.0, 8.0], [0.0, 0.0]]


def test_numbers_of_columns_keep_the_units_in_their_names():
    found = parse_log("t,x_mm,y_mm\n0,1000,1\n1,2000,1\n", "log", columns="x=2,y=3").trajectories[1]
    assert list(found.x) == [1.0, 2.0]


@pytest.mark.parametrize(
    ("text", "columns", "remark"),
    [
        ("when,x,y\n0.5,2,3\n1.5,3,3\n3.5,4,3\n", "", "choose --columns t=1 if it holds the times"),
        ("0 2 3 0 1 0 0 0\n1 3 3 0 1 0 0 0\n", "qx=5,qy=6,qz=7,qw=8", "seen from above"),
        ("t,x,y,yaw\n0,2,2,90\n1,2,3,60\n2,2.5,3.87,90\n", "yaw=yaw:rad", ""),
        ("t,x,y,hdg\n0,2,2,0\n1,2,3,45\n2,2.71,3.71,90\n3,3.71,3.71,90\n", "yaw=hdg:deg",
         "convert it if it is a compass's"),
    ],
    ids=["unknown times", "a camera", "chosen", "a compass"],
)  # fmt: skip
def test_what_is_only_doubtful_is_said(text, columns, remark):
    log = parse_log(text, "log", with_headings=True, columns=columns)
    assert log.read_as.endswith(remark)


@pytest.mark.parametrize("columns", ["x", "x=1", "speed=3", "t=", "x=1;y=2"])
def test_choices_in_another_form_are_refused(columns):
    with pytest.raises(InvalidParameter):
        parse_log("t,x,y\n0,1,1\n1,1,1\n", "log", columns=columns)
