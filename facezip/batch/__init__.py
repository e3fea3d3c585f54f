"""Many independent tasks on the processes of one machine or on a cluster; what is finished stays finished."""
